/** Localization in the lab: the switches and their effects, and the history shown in the chart. */

import type { LocalizationMessage, Values } from "../../wire/protocol";

/** The layers of a localization: the map in which a log is localized, and the particles. */
export const GIVEN_MAP = "given_map";
export const PARTICLES = "particles";
/** The layer of the lab's filter: the likelihood of a reading that ends in a cell. */
export const LIKELIHOOD_FIELD = "likelihood_field";

/** A setting of the filter that fails or that demonstrates something. */
export interface Setting {
  readonly name: string;
  readonly label: string;
  readonly values: Values;
  /** The map that the filter uses instead of the plan of the world. */
  readonly map?: "moved" | "other";
  /** The required world. */
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
    look: "two clouds, one in each room: both explain every scan. Resampling drops one of them by chance, the right one or the wrong one; only an end of the corridor tells them apart.",
  },
  {
    name: "moved",
    label: "The furniture was moved",
    values: {},
    map: "moved",
    look: "the walls still determine the pose, but scans fit less well: the likelihood field shows the furniture at its old places.",
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
    label: "Overconfident sensor model",
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

/** One point of the chart, for a used scan. */
export interface Point {
  readonly updates: number;
  readonly error: number;
  readonly entropy: number;
}

const MOST_POINTS = 400;

/** The history including a message; it restarts with the filter. */
export function grown(points: readonly Point[], message: LocalizationMessage): readonly Point[] {
  if (!message.is_on || message.error_m === null) return [];
  const last = points.at(-1);
  const before = last && message.n_updates < last.updates ? [] : points;
  if (last && message.n_updates === last.updates && before.length > 0) return before;
  const next = { updates: message.n_updates, error: message.error_m, entropy: message.entropy };
  return [...before, next].slice(-MOST_POINTS);
}

/** The inputs of a filter. */
export interface Given {
  readonly values: Values;
  readonly map: string;
  /** Name of the world. */
  readonly world: string | undefined;
}

/** Whether a setting is on, that is, everything that it sets has these values. */
export const isOn = ({ values, map, world }: Setting, given: Given): boolean =>
  Object.entries(values).every(([name, value]) => given.values[name] === value) &&
  (map === undefined || given.map === map) &&
  (world === undefined || given.world === world);

/** The inputs of the filter after a switch. A setting with its own world is switched off by going `elsewhere`. */
export function turned(setting: Setting, given: Given, elsewhere: string): Given {
  const wasOn = isOn(setting, given);
  const own = Object.keys(setting.values);
  // Values that another setting sets too are kept, unless that is on only because this one is.
  const isPart = (candidate: Setting): boolean =>
    Object.entries(candidate.values).every(([name, value]) => setting.values[name] === value);
  const others = SETTINGS.filter((setting) => isOn(setting, given) && !isPart(setting)).flatMap((setting) =>
    Object.entries(setting.values),
  );
  const rest = Object.entries(given.values).filter(([name]) => !own.includes(name));
  const values = wasOn
    ? { ...Object.fromEntries(rest), ...Object.fromEntries(others) }
    : { ...given.values, ...setting.values };
  const map = setting.map === undefined ? given.map : wasOn ? "plan" : setting.map;
  const world = setting.world === undefined ? given.world : wasOn ? elsewhere : setting.world;
  return { values, map, world };
}

/** The semi-axes (m) and the direction (rad) of an ellipse that contains 95 % of a normal density. */
export function ellipseOf(xx: number, xy: number, yy: number): readonly [long: number, short: number, turn: number] {
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const half = (variance: number): number => Math.sqrt(5.991 * Math.max(0, variance));
  return [half(middle + apart), half(middle - apart), Math.atan2(2 * xy, xx - yy) / 2];
}
