/** The map of a scene after each of its scans, made step by step and kept, so that going back costs nothing. */

import {
  copyOf,
  emptyGrid,
  emptyStatistics,
  type GridGeometry,
  type MappingConfig,
  type OccupancyGrid,
} from "../../grid/occupancyGrid";
import type { SensorModelParameters } from "../../grid/sensorModel";
import type { Pose } from "../../wire/protocol";
import { addScan, type Conditions } from "./sensing";

/** Everything that a map depends on. */
export interface Plan {
  readonly geometry: GridGeometry;
  readonly conditions: Conditions;
  readonly config: MappingConfig;
  /** The model of a ring of sonars; null for the lidar. */
  readonly cone: SensorModelParameters | null;
  /** True poses of the scans, the oldest first. */
  readonly poses: readonly Pose[];
}

/** What a plan depends on besides its poses. */
const keyOf = ({ geometry, conditions, config, cone }: Plan): string =>
  JSON.stringify([geometry, conditions, config, cone]);

/** Whether the map keeps two numbers for each cell. */
const hasStatistics = ({ config, cone }: Plan): boolean =>
  Boolean(config.prior_weight) || cone?.model === "moravec_elfes";

export class MapHistory {
  readonly key: string;
  readonly #maps: OccupancyGrid[];
  #poses: readonly Pose[] = [];

  constructor(plan: Plan) {
    this.key = keyOf(plan);
    const empty = hasStatistics(plan) ? emptyStatistics : emptyGrid;
    this.#maps = [empty(plan.geometry, plan.config.log_odds_prior)];
  }

  /** Number of scans in the newest map. */
  get count(): number {
    return this.#poses.length;
  }

  /** The map after `i` scans, limited to those that there are. */
  after(i: number): OccupancyGrid {
    const map = this.#maps[Math.min(i, this.count)];
    if (!map) throw new RangeError("A number of scans is not negative.");
    return map;
  }

  /** The log-odds of one cell before the first scan and after each. */
  ladder(index: number): readonly number[] {
    return this.#maps.map(({ logOdds }) => logOdds[index] ?? 0);
  }

  /** Add the scans that are missing, until the time is up; return whether it is complete. Later ones are kept. */
  advance(plan: Plan, isTimeUp: () => boolean): boolean {
    let same = 0;
    while (same < Math.min(this.count, plan.poses.length) && this.#poses[same] === plan.poses[same]) same++;
    if (same === plan.poses.length) return true;
    this.#maps.length = same + 1;
    this.#poses = this.#poses.slice(0, same);
    while (this.count < plan.poses.length) {
      const pose = plan.poses[this.count];
      if (!pose) break;
      const map = copyOf(this.after(this.count));
      addScan(map, pose, this.count, plan.conditions, plan.config, plan.cone, plan.poses);
      this.#maps.push(map);
      this.#poses = plan.poses.slice(0, this.count + 1);
      if (isTimeUp()) break;
    }
    return this.count >= plan.poses.length;
  }
}

const KEPT = 5;
const histories: MapHistory[] = [];

/** The history of a plan: the one that is kept for these conditions, or a new one. The oldest are dropped. */
export function historyOf(plan: Plan): MapHistory {
  const key = keyOf(plan);
  const at = histories.findIndex((entry) => entry.key === key);
  const history = histories[at] ?? new MapHistory(plan);
  if (at >= 0) histories.splice(at, 1);
  histories.push(history);
  if (histories.length > KEPT) histories.shift();
  return history;
}
