/**
 * The whole stack step by step: a map is made, saved, the robot is found on it, and drives to a goal. The particles,
 * costs and paths are those of the sections before.
 */

import { computed } from "@preact/signals";
import type { Point, Pose } from "../../wire/protocol";
import type { Wall } from "../common/world";
import { advance, INITIAL, type Settings, scattered, type Walk } from "../localization/kidnap";
import { DRIVE } from "../stage/floor";
import { onPath } from "../stage/path";
import { type Costs, combine } from "./costmap";
import { inflated, type Plan, planned, saved } from "./state";
import { boxAbout, observe, unknown } from "./world";

export type Phase = "slam" | "save" | "amcl" | "nav2";
/** Number of steps of each phase. */
const STEPS: Readonly<Record<Phase, number>> = { slam: 39, save: 4, amcl: 14, nav2: 36 };
const ORDER: readonly Phase[] = ["slam", "save", "amcl", "nav2"];
export const LENGTH = ORDER.reduce((sum, phase) => sum + STEPS[phase], 0);

/** The first step of a phase. */
export const begin = (phase: Phase): number =>
  ORDER.slice(0, ORDER.indexOf(phase)).reduce((sum, earlier) => sum + STEPS[earlier], 0);

/** The phase of a step, and how many steps of it there were before. */
export function phaseOf(step: number): readonly [phase: Phase, index: number] {
  const phase = ORDER.findLast((candidate) => begin(candidate) <= step) ?? "slam";
  return [phase, step - begin(phase)];
}

/** Scans in the map at a step of the first phase. */
export const scansAt = (index: number): number => Math.min(DRIVE.length, 2 * (index + 1));

const FIRST_GOAL: Point = [2.4, 6.4];
const WAY = 0.35;
/** The robot has arrived when it is this near to the goal, m. */
const NEAR = 0.25;
/** Something that was not there when the map was made. */
export const CRATE: readonly Wall[] = boxAbout([4.6, 2], 0.7, 0.7);
const PARKED: Pose = [10.8, 6.8, -2];
/** Nothing is known of the pose at first: a scan counts as a few beams. */
const CAREFUL: Settings = { ...INITIAL, particles: 1000, power: 0.12 };

/** A step of the drive to the goal: the robot, its particles, what it has seen, and its path. */
export interface Drive {
  readonly walk: Walk;
  readonly seen: Costs;
  readonly costs: Costs;
  readonly plan: Plan;
  readonly arrived: boolean;
}

export const FIRST_STEP = begin("nav2") + 9;
export const step = onPath(FIRST_STEP);
const goalAt = onPath(FIRST_GOAL);
export const goal = computed(() => goalAt.value);

const walks: Walk[] = [];
/** The filter after `index` scans of the third phase. */
export function walkAt(index: number): Walk {
  walks[0] ??= scattered(CAREFUL, PARKED);
  while (walks.length <= index) walks.push(advance(walks.at(-1) as Walk, CAREFUL));
  return walks[index] as Walk;
}

/** The drive so far: for the goals that it had. */
let drives: Drive[] = [];

function looking(walk: Walk, before: Costs, to: Point): Drive {
  const seen = observe(before, walk.robot, CRATE);
  const costs = inflated(combine(saved.value, seen));
  const at: Point = [walk.robot[0], walk.robot[1]];
  const arrived = Math.hypot(at[0] - to[0], at[1] - to[1]) < NEAR;
  return { walk, seen, costs, plan: planned(costs, at, to, false), arrived };
}

/** The point of a path at some way from its start. */
function ahead(path: readonly Point[], way: number): Point {
  let left = way;
  for (let k = 1; k < path.length; k++) {
    const [a, b] = [path[k - 1] as Point, path[k] as Point];
    left -= Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (left <= 0) return b;
  }
  return path.at(-1) as Point;
}

function driven({ walk, seen, plan, arrived }: Drive, to: Point): Drive {
  const [x, y, yaw] = walk.robot;
  if (arrived || !plan.path) return looking(advance(walk, INITIAL, walk.robot), seen, to);
  const [px, py] = ahead(plan.path, WAY);
  const heading = Math.hypot(px - x, py - y) > 0.01 ? Math.atan2(py - y, px - x) : yaw;
  return looking(advance(walk, INITIAL, [px, py, heading]), seen, to);
}

/** The drive after `index` steps of the last phase. */
export function driveAt(index: number): Drive {
  drives[0] ??= looking(walkAt(STEPS.amcl - 1), unknown(), goalAt.peek());
  while (drives.length <= index) drives.push(driven(drives.at(-1) as Drive, goalAt.peek()));
  return drives[index] as Drive;
}

/** Set the goal now: the path from here on is another one. */
export function setGoal(point: Point): void {
  const [phase, index] = phaseOf(step.peek());
  if (phase !== "nav2") return;
  const now = driveAt(index);
  const to: Point = [Math.min(11.3, Math.max(0.7, point[0])), Math.min(7.3, Math.max(0.7, point[1]))];
  const at: Point = [now.walk.robot[0], now.walk.robot[1]];
  const arrived = Math.hypot(at[0] - to[0], at[1] - to[1]) < NEAR;
  drives = [...drives.slice(0, index), { ...now, plan: planned(now.costs, at, to, false), arrived }];
  goalAt.value = to;
}

/** The drive from its start, to the goal of now. */
export function restart(): void {
  drives = [];
  step.value = 0;
}
