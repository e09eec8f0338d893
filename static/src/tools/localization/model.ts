/** Localization in the lab: the switches and what to look for, and the history that the chart shows. */

import type { LocalizationMessage, Values } from "../../wire/protocol";

/** The layers of a localization: the map that a log is localized in, and the particles. */
export const GIVEN_MAP = "given_map";
export const PARTICLES = "particles";

/** A setting of the filter that goes wrong or that shows something. */
export interface Setting {
  readonly name: string;
  readonly label: string;
  readonly values: Values;
  /** The map that the filter is given instead of the plan of the world. */
  readonly map?: "moved" | "other";
  /** The world that it needs. */
  readonly world?: string;
  /** What to look for. */
  readonly look: string;
}

export const SETTINGS: readonly Setting[] = [
  {
    name: "twins",
    label: "Two equal rooms",
    values: {},
    world: "twins",
    look: "two clouds, one in each room: both explain every scan. Drawing anew drops one of them by chance, the right one or the wrong one; an end of the corridor tells.",
  },
  {
    name: "moved",
    label: "The furniture was moved",
    values: {},
    map: "moved",
    look: "the walls still say where the robot is, but scans fit less well: the likelihood field shows the old places.",
  },
  {
    name: "other",
    label: "A wrong map",
    values: {},
    map: "other",
    look: "the particles wander or agree on some place, whose fit stays poor: the filter cannot tell that no place is right.",
  },
  {
    name: "few",
    label: "Too few particles",
    values: { global_particles: 200, min_particles: 100, max_particles: 200, reset_below: 0 },
    look: "none of them is near the robot, and they agree on a wrong place.",
  },
  {
    name: "sure",
    label: "Sensor model too sure of itself",
    values: { sigma_hit: 0.02, z_hit: 0.99, z_rand: 0.01, least_effective: 0, reset_below: 0 },
    look: "one scan decides: a few particles get all of the weight, and often they are the wrong ones.",
  },
  {
    name: "no-recovery",
    label: "No recovery",
    values: { reset_below: 0 },
    look: "a robot that was carried away is not found again: no particle is where it is.",
  },
];

/** One point of the chart, for a scan that was used. */
export interface Point {
  readonly updates: number;
  readonly error: number;
  readonly entropy: number;
}

const MOST_POINTS = 400;

/** The history with a message; a filter that began anew begins it anew. */
export function grown(points: readonly Point[], message: LocalizationMessage): readonly Point[] {
  if (!message.is_on || message.error_m === null) return [];
  const last = points.at(-1);
  const before = last && message.n_updates < last.updates ? [] : points;
  if (last && message.n_updates === last.updates && before.length > 0) return before;
  const next = { updates: message.n_updates, error: message.error_m, entropy: message.entropy };
  return [...before, next].slice(-MOST_POINTS);
}

/** The map of the last setting that is on and has one. */
export const mapOf = (on: readonly string[]): string =>
  SETTINGS.findLast(({ name, map }) => map !== undefined && on.includes(name))?.map ?? "plan";

/** The settings that are on once one is turned: only one of them can say which map the filter gets. */
export function turned(on: readonly string[], name: string): readonly string[] {
  if (on.includes(name)) return on.filter((one) => one !== name);
  const hasMap = (one: string): boolean =>
    SETTINGS.some((setting) => setting.name === one && setting.map !== undefined);
  return [...on.filter((one) => !(hasMap(name) && hasMap(one))), name];
}

/** The values of all settings that are on, together. */
export const valuesOf = (on: readonly string[]): Values =>
  Object.assign({}, ...SETTINGS.filter(({ name }) => on.includes(name)).map(({ values }) => values));

/** The half axes (m) and the direction (rad) of an ellipse that holds 95 % of a normal density. */
export function ellipseOf(xx: number, xy: number, yy: number): readonly [long: number, short: number, turn: number] {
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const half = (variance: number): number => Math.sqrt(5.991 * Math.max(0, variance));
  return [half(middle + apart), half(middle - apart), Math.atan2(2 * xy, xx - yy) / 2];
}
