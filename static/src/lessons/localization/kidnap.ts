/** A robot that walks about the floor and may be carried away, and the augmented MCL that follows it. */

import { type Alphas, odometryControl, odometrySigmas, sampleMotion } from "../../grid/motionModel";
import { augmentedShare, lowVarianceSampler, normalized } from "../../grid/particleFilter";
import { wrapped } from "../../grid/poses";
import { seeded } from "../../grid/random";
import type { Pose } from "../../wire/protocol";
import { castRay } from "../common/world";
import { endPoints, isFree, logLikelihood, MAPPED, randomPose, threeNormals } from "./field";

export interface Settings {
  readonly particles: number;
  readonly alphaSlow: number;
  readonly alphaFast: number;
  /** Factor of the log-likelihoods: less than 1 where nothing is known yet, so that one scan does not decide alone. */
  readonly power?: number;
}

export const INITIAL: Settings = { particles: 800, alphaSlow: 0.02, alphaFast: 0.3 };

/** A scan of the walk. */
export interface Moment {
  readonly slow: number;
  readonly fast: number;
  /** Share of random particles that were added. */
  readonly share: number;
  /** Share of the particles within {@link NEAR} of the robot. */
  readonly near: number;
  readonly kidnapped: boolean;
}

export interface Walk {
  readonly robot: Pose;
  /** The particles before they are resampled, and their weights, Σ = 1. */
  readonly particles: readonly Pose[];
  readonly weights: Float64Array;
  /** Which of them were random: the last ones. */
  readonly random: number;
  readonly past: readonly Moment[];
  /** The robot was carried since the last scan. */
  readonly carried: boolean;
}

/** Metres. */
export const NEAR = 0.5;
const STEP = 0.35;
const ALPHAS: Alphas = [0.2, 0.2, 0.2, 0.2];
const SEED = 7;

const START: Pose = [1.2, 1.7, 0];
/** Where the button carries the robot, by turns. */
const PLACES: readonly Pose[] = [
  [8.2, 6.4, Math.PI],
  [2.2, 6.2, -Math.PI / 2],
  [10.8, 2.4, Math.PI],
];

/** The robot's next pose: straight on where there is room, else it turns to the side with more. */
export function wander([x, y, yaw]: Pose): Pose {
  const clear = (turn: number): number => castRay(MAPPED, x, y, yaw + turn);
  const [left, right] = [clear(0.9), clear(-0.9)];
  const side = left > right ? 1 : -1;
  if (Math.min(clear(0), clear(0.4), clear(-0.4)) < 0.75) return [x, y, wrapped(yaw + side * 0.7)];
  const turned = wrapped(yaw + side * Math.min(0.25, 0.08 * Math.abs(left - right)));
  return [x + STEP * Math.cos(turned), y + STEP * Math.sin(turned), turned];
}

/** A cloud about the robot, as after a start with a hint. */
export function start({ particles }: Settings): Walk {
  const random = seeded(SEED);
  const cloud = Array.from({ length: particles }, (): Pose => {
    const [a, b, c] = threeNormals(random);
    return [START[0] + 0.2 * a, START[1] + 0.2 * b, START[2] + 0.15 * c];
  });
  return {
    robot: START,
    particles: cloud,
    weights: new Float64Array(particles).fill(1 / particles),
    random: 0,
    past: [],
    carried: false,
  };
}

/** Poses anywhere: nothing is known of where the robot is. */
export function scattered({ particles }: Settings, robot: Pose): Walk {
  const random = seeded(SEED + 1);
  return {
    robot,
    particles: Array.from({ length: particles }, () => randomPose(random)),
    weights: new Float64Array(particles).fill(1 / particles),
    random: particles,
    past: [],
    carried: false,
  };
}

/** Carry the robot to a pose; it is not told. */
export const carry = (walk: Walk, robot: Pose): Walk => ({ ...walk, robot, carried: true });

/** The place, of those in turn, that is far from the robot. */
export const elsewhere = ({ robot, past }: Walk): Pose =>
  PLACES.map((_, k) => PLACES[(past.length + k) % PLACES.length] as Pose).find(
    ([x, y]) => Math.hypot(x - robot[0], y - robot[1]) > 3,
  ) ?? START;

/** One motion, of its own or to a pose, and one scan: tables 8.2 and 8.3, with the likelihood field of table 6.3. */
export function advance(
  walk: Walk,
  { particles: count, alphaSlow, alphaFast, power = 1 }: Settings,
  robot: Pose = wander(walk.robot),
): Walk {
  const at = walk.past.length;
  const random = seeded(1000 * SEED + at);
  const last = walk.past.at(-1);
  // Drawn by the weights of the last scan; the share of random ones comes from its averages.
  const drawn = lowVarianceSampler(walk.weights, random() / count, count);
  const fresh = Math.round((last?.share ?? 0) * count);
  const control = odometryControl(walk.robot, robot);
  const sigmas = odometrySigmas(control, ALPHAS);
  // The drawn ones are in the order of the old cloud: the random ones replace every n-th.
  const isRandom = (i: number): boolean => Math.floor(((i + 1) * fresh) / count) > Math.floor((i * fresh) / count);
  const moved: Pose[] = [];
  const added: Pose[] = [];
  drawn.forEach((k, i) => {
    if (isRandom(i)) added.push(randomPose(random));
    else moved.push(sampleMotion(control, sigmas, walk.particles[k] as Pose, threeNormals(random)));
  });
  const particles = [...moved, ...added];
  const points = endPoints(robot, 100 * SEED + at);
  const logs = Float64Array.from(particles, (pose) =>
    isFree([pose[0], pose[1]], 0) ? logLikelihood(points, pose) : Number.NEGATIVE_INFINITY,
  );
  const most = logs.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY);
  const weights = normalized(logs.map((log) => Math.exp(power * (log - most))));
  const root = 1 / Math.max(1, points.length);
  const average = logs.reduce((sum, log) => sum + Math.exp(root * log), 0) / count;
  const [slow, fast, share] = last
    ? augmentedShare(average, last.slow, last.fast, alphaSlow, alphaFast)
    : ([average, average, 0] as const);
  const near = weights.reduce((sum, w, i) => sum + (isNear(particles[i] as Pose, robot) ? w : 0), 0);
  return {
    robot,
    particles,
    weights,
    random: added.length,
    past: [...walk.past, { slow, fast, share, near, kidnapped: walk.carried }],
    carried: false,
  };
}

const isNear = (a: Pose, b: Pose): boolean => Math.hypot(a[0] - b[0], a[1] - b[1]) < NEAR;

/** Scans before the robot is carried away, and after it, in the first state of the figure. */
export const FOLLOWED = 14;
const LOST = 4;

/** The first state: the robot was followed, then carried away, and the cloud begins to scatter. */
export function firstState(settings: Settings): Walk {
  let walk = start(settings);
  for (let i = 0; i < FOLLOWED; i++) walk = advance(walk, settings);
  walk = carry(walk, PLACES[0] as Pose);
  for (let i = 0; i < LOST; i++) walk = advance(walk, settings);
  return walk;
}
