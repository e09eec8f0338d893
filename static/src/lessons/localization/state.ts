/** What a reader can change in the sections on localization. */

import { computed, signal } from "@preact/signals";
import { normalized } from "../../grid/particleFilter";
import { seeded } from "../../grid/random";
import type { Pose } from "../../wire/protocol";
import { onPath } from "../stage/path";
import { endPoints, logLikelihood, randomPose } from "./field";
import { advance, firstState, INITIAL, type Settings, type Walk } from "./kidnap";

/** Where the robot is whose scan weighs the poses of the first section. */
export const scanningAt = onPath<Pose>([7.6, 4.3, 2.6]);
/** Where a scan is supposed to be taken, and where it was. */
export const supposedAt = onPath<Pose>([3.1, 2.15, 0.25]);
export const TAKEN_AT: Pose = [2.6, 1.9, 0.1];

const ANYWHERE = 4000;
/** Every n-th beam is used, so that more than one pose fits. */
const EVERY = 5;
const poses = computed(() => {
  const random = seeded(11);
  return Array.from({ length: ANYWHERE }, () => randomPose(random));
});

/** Poses all over the floor, and their weights by one scan of the robot. */
export const weighed = computed(() => {
  const points = endPoints(scanningAt.value, 5).filter((_, i) => i % EVERY === 0);
  const logs = Float64Array.from(poses.value, (pose) => logLikelihood(points, pose));
  const most = logs.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY);
  return { poses: poses.value, weights: normalized(logs.map((log) => Math.exp(log - most))), points };
});

export const settings = onPath<Settings>(INITIAL);
/** The walk that a reader has continued; null for the first one. */
const continued = signal<Walk | null>(null);
const first = computed(() => firstState(settings.value));
export const walk = computed(() => continued.value ?? first.value);
export const continueWalk = (change: (now: Walk) => Walk): void => {
  continued.value = change(walk.peek());
};
export const walkAgain = (): void => {
  continued.value = null;
};

const MOST_SCANS = 200;
const MOST_OF_THE_BELIEF = 0.5;

/** Continue the first walk of the figure until the robot is found; return the scans since its first state. */
export function foundAgain(): number {
  let walk = firstState(INITIAL);
  const before = walk.past.length;
  while ((walk.past.at(-1)?.near ?? 0) <= MOST_OF_THE_BELIEF && walk.past.length < before + MOST_SCANS) {
    walk = advance(walk, INITIAL);
  }
  settings.value = INITIAL;
  continueWalk(() => walk);
  return walk.past.length - before;
}
