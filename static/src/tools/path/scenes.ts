/** Scenes that show why a path is as it is: what each step does, and what to look for then. */

import { NO_EDITS } from "../../store/editing";
import type { Store } from "../../store/store";
import type { DrawnSolid, Point, Values } from "../../wire/protocol";
import { OUTLINES } from "../costmap/footprint";
import { costmapOf } from "../costmap/state";

interface Step {
  readonly label: string;
  readonly look: string;
  readonly run: (store: Store) => void;
}

export interface Scene {
  readonly name: string;
  readonly label: string;
  readonly steps: readonly Step[];
}

/** The world of the scenes, and where the robot stands in it: in the corridor, looking along it. */
export const WORLD = "office";
const START: Point = [6.2, 7];
const CORRIDOR: Point = [12, 7];
const BEHIND: Point = [10.5, 7];
const KITCHEN: Point = [7.5, 9.5];
const UNSEEN: Point = [17, 11];
const TABLE: DrawnSolid = ["box", 830, 670, 890, 730];
const STATIC_ONLY: Values = { obstacle_layer: false, dynamic_layer: false };

interface Setting {
  readonly values: Values;
  readonly goal: Point;
  readonly footprint?: readonly Point[];
  /** Solids that stand there before the costmap is made. */
  readonly added?: readonly DrawnSolid[];
  /** Whether the map begins again, with this clamp. */
  readonly clamp?: boolean;
}

/** Put world, robot, costmap and goal as a scene begins. */
function set(store: Store, { values, goal, footprint, added = [], clamp }: Setting): void {
  store.send({ type: "edit", added, erased: [] });
  if (clamp !== undefined) {
    store.setTogether("clamp", { clamp });
    store.send({ type: "restart" });
  }
  store.send({ type: "auto", value: false });
  store.send({ type: "teleport", x: START[0], y: START[1], yaw: 0 });
  store.send({ type: "costmap", value: false });
  store.send({ type: "costmap", values, footprint: footprint ?? OUTLINES[0]?.corners ?? null });
  store.send({ type: "goal", x: goal[0], y: goal[1], drives: false });
  store.send({ type: "play" });
  const state = costmapOf(store);
  state.over.value = "costmap";
  state.lastTool.value = state.tool.value = "goal";
  state.asked.value = null;
  store.viewHeld.value = false;
}

const takeAway = (store: Store): void => store.send({ type: "edit", ...NO_EDITS });

export const SCENES: readonly Scene[] = [
  {
    name: "table",
    label: "The table is taken away",
    steps: [
      {
        label: "Put a table in the way",
        look: "The map of the static layer is the plan without the table. The scans put it into the dynamic layer, and the path goes around it.",
        run: (store) => {
          const values = { map: "plan", obstacle_layer: false, clearing: false, lifetime: 8 };
          set(store, { values, goal: CORRIDOR });
          store.send({ type: "edit", added: [TABLE], erased: [] });
        },
      },
      {
        label: "Take the table away",
        look: "The path still goes around the empty place, until the obstacle’s lifetime of 8 s is over. Switch “Beams clear” on under Costmap, and it is straight at once.",
        run: takeAway,
      },
    ],
  },
  {
    name: "clamp",
    label: "The belief without its clamp",
    steps: [
      {
        label: "Map a table, clamp off",
        look: "Only the static layer is on: the belief itself. Each scan adds to the log-odds of the table’s cells, without a limit. Let some seconds pass.",
        run: (store) => {
          // What the table hides is unknown, and may be crossed.
          const values = { ...STATIC_ONLY, allow_unknown: true };
          set(store, { values, goal: BEHIND, added: [TABLE], clamp: false });
        },
      },
      {
        label: "Take the table away",
        look: "The path goes around nothing: each cell has to be seen free until the misses outweigh all the hits. Where no beam passes, the robot never drives again.",
        run: takeAway,
      },
    ],
  },
  {
    name: "unknown",
    label: "Unknown treated as free",
    steps: [
      {
        label: "Send it into unseen space",
        look: "The path crosses the void, also walls that no scan has seen. Switch “Drive through unknown” off: now there is none.",
        run: (store) => set(store, { values: { allow_unknown: true }, goal: UNSEEN, clamp: true }),
      },
    ],
  },
  {
    name: "wide",
    label: "Inflation too wide for the door",
    steps: [
      {
        label: "Make the robot 1 m wide",
        look: "The door is 0.95 m wide. Within the inscribed radius of 0.51 m of its posts every cell is inscribed (magenta): the door is closed.",
        run: (store) => {
          const footprint = [[0.5, 0.5] as const, [-0.5, 0.5] as const, [-0.5, -0.5] as const, [0.5, -0.5] as const];
          set(store, { values: { map: "plan", inflation_radius: 1.2 }, goal: KITCHEN, footprint });
        },
      },
      {
        label: "Make it narrow again",
        look: "The inflation is as wide as before, but its cells only cost more and are not inscribed: the path leads through the middle of the door.",
        run: (store) => costmapOf(store).setFootprint(OUTLINES[0]?.corners ?? []),
      },
    ],
  },
];
