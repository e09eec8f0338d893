/** The path of the lab's robot: its goal, planning and driving, and scenes that explain it. */

import { effect, signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { NO_EDITS } from "../../store/editing";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { KINDS } from "../../wire/kinds";
import type { DrawnSolid, PathMessage, Point, Values } from "../../wire/protocol";
import { Begin, End, useCostmap, useRows } from "../costmap/BeginEnd";
import { OUTLINES } from "../costmap/footprint";
import { costmapOf } from "../costmap/state";
import { OverChoice, Tools } from "../costmap/Tools";
import { WhyCost } from "../costmap/WhyCost";
import { ParameterRows } from "../parameters/ParameterRows";
import { pathOf } from "./state";
import "../costmap/costmap.css";

interface Step {
  readonly label: string;
  readonly look: string;
  readonly run: (store: Store) => void;
}

interface Scene {
  readonly name: string;
  readonly label: string;
  readonly steps: readonly Step[];
}

/** The world of the scenes, and the robot's initial pose in it: in the corridor, facing along it. */
const WORLD = "office";
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
  /** Solids that are added before the costmap is created. */
  readonly added?: readonly DrawnSolid[];
  /** Whether the map is restarted, with this clamp. */
  readonly clamp?: boolean;
}

/** Set world, robot, costmap and goal to the start of a scene. */
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

const SCENES: readonly Scene[] = [
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
          // The area hidden by the table is unknown, and may be crossed.
          const values = { ...STATIC_ONLY, allow_unknown: true };
          set(store, { values, goal: BEHIND, added: [TABLE], clamp: false });
        },
      },
      {
        label: "Take the table away",
        look: "The path goes around nothing: each cell must be measured as free until the misses outweigh all the hits. Where no beam passes, the robot never drives there again.",
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
        look: "The path crosses unknown space, even walls that no scan has seen. Switch “Drive through unknown” off: now there is no path.",
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

interface Shown {
  readonly scene: Scene;
  readonly step: number;
}

/** The scene shown by each store; it is kept while another group is open. */
const SHOWN = new WeakMap<Store, ReturnType<typeof signal<Shown | null>>>();

function shownOf(store: Store) {
  const known = SHOWN.get(store);
  if (known) return known;
  const made = signal<Shown | null>(null);
  SHOWN.set(store, made);
  return made;
}

export function Scenes({ store }: { readonly store: Store }) {
  const shown = useMemo(() => shownOf(store), [store]);
  const now = shown.value ?? null;
  const run = (scene: Scene): void => {
    const step = now?.scene === scene ? (now.step + 1) % scene.steps.length : 0;
    const begin = (): void => scene.steps[step]?.run(store);
    shown.value = { scene, step };
    if (store.world.peek()?.name === WORLD) begin();
    else {
      store.chooseWorld(WORLD);
      when(() => store.world.value?.name === WORLD, begin);
    }
  };
  return (
    <section class="stack-narrow" aria-label="Try">
      <h2>Try</h2>
      {SCENES.map((scene) => {
        const isShown = now?.scene === scene;
        const next = isShown ? (now.step + 1) % scene.steps.length : 0;
        return (
          <div key={scene.name} class={isShown ? "navigation-scene shown" : "navigation-scene"}>
            <span>{scene.label}</span>
            <button type="button" class={`button${isShown && next > 0 ? " primary" : ""}`} onClick={() => run(scene)}>
              {scene.steps[next]?.label}
            </button>
            <p role="status">
              {isShown && (
                <>
                  <b>Look for:</b> {scene.steps[now.step]?.look}
                </>
              )}
            </p>
          </div>
        );
      })}
    </section>
  );
}

/** Do `task` once `isReady`, which reads signals, is true. */
function when(isReady: () => boolean, task: () => void): void {
  let isDone = false;
  const stop = effect(() => {
    if (isDone || !isReady()) return;
    isDone = true;
    queueMicrotask(() => {
      stop();
      task();
    });
  });
}

const ROWS = ["allow_unknown", "use_astar", "lookahead_dist", "desired_linear_vel", "tolerance"];

export function PathGroup({ store }: { readonly store: Store }) {
  useCostmap(store);
  const rows = useRows(store, ROWS);
  const set = useMemo(
    () => (name: string, value: number | string | boolean) => store.setPart("costmap", { [name]: value }),
    [store],
  );
  if (costmapOf(store).costmap.value?.is_on !== true) return <Begin store={store} />;
  return (
    <div class="navigation stack-narrow">
      <Tools store={store} />
      <Outcome store={store} />
      {costmapOf(store).lastTool.value === "cost" && <WhyCost store={store} />}
      {isDriven(store) && <Scenes store={store} />}
      <OverChoice store={store} />
      <div class="navigation-settings">
        <ParameterRows rows={rows} values={costmapOf(store).values.values} set={set} />
      </div>
      <End store={store} />
    </div>
  );
}

/** Whether the robot can drive along the path; that of a log cannot. */
const isDriven = (store: Store): boolean => KINDS[store.hello.value?.kind ?? ""]?.isDriven ?? false;

function Outcome({ store }: { readonly store: Store }) {
  const path = pathOf(store).path.value;
  const goal = path?.goal ?? null;
  const isRefused = goal !== null && path?.length === null;
  const drive = (drives: boolean): void => {
    const [x, y] = goal ?? [0, 0];
    store.send({ type: "goal", x, y, drives });
    if (drives) store.send({ type: "play" });
  };
  return (
    <div class={`navigation-outcome${isRefused ? " refused" : ""}`}>
      {!isRefused && <PathNumbers path={goal && path} />}
      <p role="status">{goal ? path?.reason : "There is no goal yet."}</p>
      {goal && path && (
        <div class="actions">
          {isDriven(store) && (
            <Button
              kind={path.drives ? undefined : "primary"}
              icon={path.drives ? "pause" : "play"}
              disabled={path.length === null && !path.drives}
              onClick={() => drive(!path.drives)}
            >
              {path.drives ? "Stop" : "Drive there"}
            </Button>
          )}
          <Button kind="quiet" onClick={() => pathOf(store).setGoal(null)}>
            Remove goal
          </Button>
        </div>
      )}
    </div>
  );
}

interface PathNumbersProps {
  /** The path; null without a goal. */
  readonly path: PathMessage | null;
}

/** Numbers of a path. Without a goal they are dashes, which show what will be there. */
export function PathNumbers({ path }: PathNumbersProps) {
  const number = (value: number | null | undefined, digits: number, unit: string): string =>
    value === null || value === undefined ? `– ${unit}` : `${written(value, digits)} ${unit}`;
  const rows: [label: string, text: string][] = [["Path", number(path?.length, 1, "m")]];
  if (!path || path.travel_s !== null) rows.push(["Travel time", number(path?.travel_s, 1, "s")]);
  rows.push(["Cost", path ? Math.round(path.cost ?? 0).toLocaleString("en") : "–"]);
  rows.push(["Planned in", number(path?.plan_ms, 1, "ms")]);
  if (path && path.speed_limit !== null) rows.push(["Speed limit", path.speed_limit]);
  return (
    <dl class={`number-row${path ? "" : " awaited"}`}>
      {rows.map(([label, text]) => (
        <div key={label}>
          <dt>{label}</dt>
          <dd>{text}</dd>
        </div>
      ))}
    </dl>
  );
}
