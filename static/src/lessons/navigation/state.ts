/** What a reader can change in the sections on costmaps and paths, and what follows from it. */

import { computed } from "@preact/signals";
import { type Inflation, LETHAL, NO_INFORMATION } from "../../grid/costs";
import type { Point, Pose } from "../../wire/protocol";
import { onPath } from "../stage/path";
import { type Costs, combine, inflate } from "./costmap";
import { type Ground, pathBack, type Search, search, stepCosts } from "./planner";
import {
  boxAbout,
  cellOf,
  centreOfCell,
  decayLayer,
  GEOMETRY,
  keepoutLayer,
  observe,
  staticLayer,
  unknown,
} from "./world";

export const INFLATION: Inflation = { inflation_radius: 0.7, cost_scaling_factor: 3 };
export const ROBOT_RADIUS = 0.2;
/** Shared by all these sections. */
export const inflation = onPath<Inflation>(INFLATION);
export const robotRadius = onPath(ROBOT_RADIUS);

export const saved = computed(staticLayer);
export const inflated = (costs: Costs): Costs => inflate(costs, GEOMETRY, robotRadius.value, inflation.value);

// --- layers ----------------------------------------------------------------------------------------------------------

export const LAYERS = [
  { id: "static", name: "static", text: "the saved map" },
  { id: "obstacle", name: "obstacle", text: "the current scan: a crate" },
  { id: "dynamic", name: "dynamic", text: "recent scans: someone’s trail" },
  { id: "keepout", name: "keepout", text: "a zone painted by hand" },
  { id: "inflation", name: "inflation", text: "cost around lethal cells" },
] as const;
type LayerId = (typeof LAYERS)[number]["id"];

export const OBSERVER: Pose = [5.4, 1.5, 0];
export const CRATE = 0.5;
export const crateAt = onPath<Point>([7.2, 1.3]);
export const lifetime = onPath(4);
export const probeAt = onPath<Point>([6.75, 1.75]);
/** The same on the inflated map alone. */
export const doorAt = onPath<Point>([7.45, 3.15]);
const ALL: Readonly<Record<LayerId, boolean>> = {
  static: true,
  obstacle: true,
  dynamic: true,
  keepout: true,
  inflation: true,
};
export const switched = onPath(ALL);

/** A layer's own costs, and the costmap after it. */
export interface Sheet {
  readonly id: LayerId;
  readonly own: Costs;
  readonly master: Costs;
}

export const sheets = computed<readonly Sheet[]>(() => {
  let master = unknown();
  return LAYERS.map(({ id }) => {
    const own =
      id === "static"
        ? saved.value
        : id === "obstacle"
          ? observe(unknown(), OBSERVER, boxAbout(crateAt.value, CRATE, CRATE))
          : id === "dynamic"
            ? decayLayer(lifetime.value)
            : id === "keepout"
              ? keepoutLayer()
              : inflated(master);
    if (switched.value[id]) master = id === "inflation" ? own : combine(master, own);
    return { id, own, master };
  });
});

// --- a path ----------------------------------------------------------------------------------------------------------

export interface Plan extends Search {
  readonly path: readonly Point[] | null;
  /** Metres. */
  readonly length: number;
}

const TABLE = { known: stepCosts(false), any: stepCosts(true) };

/** The cheapest path between two points over inflated costs. */
export function planned(costs: Costs, from: Point, to: Point, aStar: boolean, allowUnknown = false): Plan {
  const { rows, cols } = GEOMETRY;
  const ground: Ground = { costs, rows, cols, table: allowUnknown ? TABLE.any : TABLE.known };
  const [start, goal] = [cellOf(from), cellOf(to)];
  const isBlocked = (cell: number): boolean => cell < 0 || !Number.isFinite(ground.table[costs[cell] ?? LETHAL]);
  const blocked = isBlocked(start) || isBlocked(goal);
  const searched = blocked
    ? { potential: new Float64Array(costs.length).fill(Number.POSITIVE_INFINITY), order: [] }
    : search(ground, start, goal, aStar);
  const cells = blocked ? null : pathBack(ground, searched.potential, start, goal);
  const path = cells?.map(centreOfCell) ?? null;
  const length = (path ?? []).reduce(
    (sum, [x, y], i, all) => sum + (i === 0 ? 0 : Math.hypot(x - (all[i - 1]?.[0] ?? 0), y - (all[i - 1]?.[1] ?? 0))),
    0,
  );
  return { ...searched, path, length };
}

export const pathStart = onPath<Point>([2.2, 6.4]);
export const pathGoal = onPath<Point>([10.6, 6.2]);
export const method = onPath<"dijkstra" | "a_star">("dijkstra");
/** Share of the search that is shown. */
export const progress = onPath(1);
export const groundCosts = computed(() => inflated(saved.value));
export const plan = computed(() =>
  planned(groundCosts.value, pathStart.value, pathGoal.value, method.value === "a_star"),
);

// --- what the moving table leaves ------------------------------------------------------------------------------------

export type Place = "static" | "obstacle" | "dynamic";
export const TABLE_AT: Point = [5.7, 2.15];
export const TABLE_SIZE = [0.7, 1.9] as const;
const GOAL: Point = [10.4, 2.4];
export const tableGoal = GOAL;
export const placeOfTable = onPath<Place>("obstacle");
/** Seconds since the table was taken away, and the lifetime of the dynamic layer. */
export const since = onPath(12);
export const tableLifetime = onPath(20);
export const walkerAt = onPath<Pose>([1.6, 2.4, 0]);
/** Where the robot has been since the table is gone. */
export const looked = onPath<readonly Pose[]>([]);

/** The marks that the table left when it was seen from both sides. */
const marks = computed(() => {
  const table = boxAbout(TABLE_AT, ...TABLE_SIZE);
  let layer = unknown();
  for (const x of [3.4, 8]) layer = observe(layer, [x, 2.1, 0], table);
  return layer.map((cost, i) => {
    const [x, y] = centreOfCell(i);
    const isNear = Math.abs(x - TABLE_AT[0]) < 0.6 && Math.abs(y - TABLE_AT[1]) < 1.1;
    return isNear && cost === LETHAL ? cost : NO_INFORMATION;
  });
});

/** What the costmap still has of the table: in the map permanently, in a layer until it is cleared or forgotten. */
export const remains = computed(() => {
  const place = placeOfTable.value;
  if (place === "dynamic" && since.value > tableLifetime.value) return unknown();
  if (place === "static") return marks.value;
  let layer = marks.value;
  for (const pose of looked.value) layer = observe(layer, pose, []);
  return layer.map((cost, i) => (marks.value[i] === LETHAL && cost === LETHAL ? LETHAL : NO_INFORMATION));
});
export const tableCosts = computed(() => inflated(combine(saved.value, remains.value)));
const at = computed<Point>(() => [walkerAt.value[0], walkerAt.value[1]]);
export const tablePlan = computed(() => planned(tableCosts.value, at.value, GOAL, false));
export const freePlan = computed(() => planned(groundCosts.value, at.value, GOAL, false));
