/** What the stage shows beside the sections on costmaps and paths. */

import type { Signal } from "@preact/signals";
import { nameOfCost } from "../../grid/costs";
import { plural, written } from "../../ui/numbers";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Walls } from "../common/Scene";
import type { StageTransform } from "../common/Stage";
import { isFree } from "../localization/field";
import { type MarkProps, type Scene, scene } from "../stage/scene";
import { paintCosts, paintPath, paintPotential } from "./paint";
import {
  CRATE,
  crateAt,
  doorAt,
  freePlan,
  groundCosts,
  looked,
  OBSERVER,
  pathGoal,
  pathStart,
  placeOfTable,
  plan,
  probeAt,
  progress,
  remains,
  saved,
  sheets,
  since,
  TABLE_AT,
  TABLE_SIZE,
  tableCosts,
  tableGoal,
  tableLifetime,
  tablePlan,
  walkerAt,
} from "./state";
import { boxAbout, cellOf, distanceToLethal } from "./world";

const SCANS = 77;
const sizeOf = (transform: StageTransform): number => Math.max(8, Math.min(22, 0.2 * transform.metre));
const inWords = ([x, y]: readonly number[]): string => `${written(x ?? 0, 2)} m, ${written(y ?? 0, 2)} m`;
const inside = ([x, y]: Point): Point => [Math.min(11.3, Math.max(0.7, x)), Math.min(7.3, Math.max(0.7, y))];

/** A cross under which costs are read. */
function Probe({ transform, place }: { transform: StageTransform; place: Signal<Point> }) {
  return (
    <DragHandle
      transform={transform}
      at={place.value}
      label="Cell whose cost is read"
      sentence="Selects the cell whose cost is stated."
      text={inWords(place.value)}
      tone="neutral"
      step={0.1}
      onMove={(point) => {
        place.value = inside(point);
      }}
    >
      <path class="probe halo" d="M-13 0H-5M5 0H13M0 -13V-5M0 5V13" />
      <path class="probe" d="M-13 0H-5M5 0H13M0 -13V-5M0 5V13" />
    </DragHandle>
  );
}

function Standing({ transform, pose }: { transform: StageTransform; pose: Pose }) {
  return (
    <g transform={`translate(${transform.x(pose[0])} ${transform.y(pose[1])})`}>
      <RobotShape yaw={pose[2]} size={sizeOf(transform)} />
    </g>
  );
}

/** A goal: a ring with a dot; a cross where no path leads there. */
export function Goal({ refused }: { refused: boolean }) {
  return (
    <g class={refused ? "goal refused" : "goal"}>
      <circle r={11} />
      {refused ? <path d="M-5 -5L5 5M5 -5L-5 5" /> : <circle class="goal-dot" r={4} />}
    </g>
  );
}

function LayerMarks({ transform }: MarkProps) {
  return (
    <>
      <Walls transform={transform} walls={boxAbout(crateAt.value, CRATE, CRATE)} tone="wall" />
      <Standing transform={transform} pose={OBSERVER} />
      <DragHandle
        transform={transform}
        at={crateAt.value}
        label="Crate"
        sentence="Moves a crate that is not in the map; the robot sees it within 2.5 m."
        text={inWords(crateAt.value)}
        tone="hit"
        step={0.1}
        onMove={(point) => {
          const to = inside(point);
          if (Math.hypot(to[0] - OBSERVER[0], to[1] - OBSERVER[1]) > 0.6) crateAt.value = to;
        }}
      />
      <Probe transform={transform} place={probeAt} />
    </>
  );
}

const costAtProbe = (): string => {
  const cost = sheets.value.at(-1)?.master[cellOf(probeAt.value)] ?? 255;
  return cost === 255 ? "unknown" : nameOfCost(cost) === String(cost) ? `cost ${cost}` : `${nameOfCost(cost)}, ${cost}`;
};

export const layersScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: (context, at) => paintCosts(context, at, sheets.value.at(-1)?.master ?? saved.value),
    drawing: LayerMarks,
    caption: () => `The costmap of all layers that are switched on. Under the cross: ${costAtProbe()}.`,
    task: "Drag the cross, and the crate with the round handle.",
  });

function DoorProbe({ transform }: MarkProps) {
  return <Probe transform={transform} place={doorAt} />;
}

export const inflationScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: (context, at) => paintCosts(context, at, groundCosts.value),
    drawing: DoorProbe,
    caption: () => {
      const distance = distanceToLethal(saved.value, doorAt.value);
      const door = groundCosts.value[cellOf([7.75, 3.25])] ?? 0;
      return `Under the cross, ${written(distance, 2)} m from the nearest lethal cell: cost ${groundCosts.value[cellOf(doorAt.value)] ?? 0}. In the middle of the right door: ${door}${door >= 253 ? ", so that no path leads through it" : ""}.`;
    },
    task: "Drag the cross.",
  });

interface EndProps {
  readonly transform: StageTransform;
  readonly goal: boolean;
}

function PathEnd({ transform, goal }: EndProps) {
  const end = goal ? pathGoal : pathStart;
  return (
    <DragHandle
      transform={transform}
      at={end.value}
      label={goal ? "Goal" : "Robot"}
      sentence={goal ? "Moves the goal; the path follows." : "Moves the robot; the path begins there."}
      text={`${inWords(end.value)}, ${plan.value.path ? `path of ${written(plan.value.length, 1)} m` : "no path"}`}
      step={0.2}
      onMove={(point) => {
        end.value = inside(point);
      }}
    >
      {goal ? <Goal refused={!plan.value.path} /> : <RobotShape yaw={0} size={sizeOf(transform)} />}
    </DragHandle>
  );
}

function PathMarks({ transform }: MarkProps) {
  return (
    <>
      <PathEnd transform={transform} goal={false} />
      <PathEnd transform={transform} goal />
    </>
  );
}

export const pathScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: (context, at) => {
      paintCosts(context, at, groundCosts.value);
      paintPotential(context, at, plan.value, progress.value);
      if (plan.value.path && progress.value === 1) paintPath(context, at, plan.value.path);
    },
    drawing: PathMarks,
    caption: () => {
      const { path, length, order } = plan.value;
      const searched = `${Math.ceil(progress.value * order.length).toLocaleString("en")} cells expanded`;
      if (!path) return `No path: the goal or a door on the way is blocked. ${searched}.`;
      return `${searched}; each band of colour has one cost to come. The path is ${written(length, 1)} m long.`;
    },
    task: "Drag the goal or the robot.",
  });

const isGone = (): boolean => since.value > 0;

function TableMarks({ transform }: MarkProps) {
  const pose = walkerAt.value;
  return (
    <>
      <Walls transform={transform} walls={boxAbout(TABLE_AT, ...TABLE_SIZE)} tone={isGone() ? "wall gone" : "wall"} />
      <g transform={`translate(${transform.x(tableGoal[0])} ${transform.y(tableGoal[1])})`}>
        <Goal refused={!tablePlan.value.path} />
      </g>
      <DragHandle
        transform={transform}
        at={[pose[0], pose[1]]}
        label="Robot"
        sentence="Moves the robot; from less than 3 m it sees that the table is gone, and clears the obstacle layers."
        text={inWords(pose)}
        step={0.2}
        onMove={([x, y]) => {
          if (!isFree([x, y])) return;
          walkerAt.value = [x, y, pose[2]];
          const last = looked.peek().at(-1);
          if (isGone() && (!last || Math.hypot(x - last[0], y - last[1]) > 0.25) && looked.peek().length < 60)
            looked.value = [...looked.peek(), [x, y, 0]];
        }}
      >
        <RobotShape yaw={pose[2]} size={sizeOf(transform)} />
      </DragHandle>
    </>
  );
}

const WHERE = {
  static: "the saved map",
  obstacle: "the obstacle layer",
  dynamic: "the layer with a lifetime",
} as const;

export const lifetimeScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: (context, at) => {
      paintCosts(context, at, tableCosts.value);
      if (freePlan.value.path) paintPath(context, at, freePlan.value.path, true);
      if (tablePlan.value.path) paintPath(context, at, tablePlan.value.path);
    },
    drawing: TableMarks,
    caption: () => {
      const left = remains.value.reduce((sum, cost) => sum + (cost === 254 ? 1 : 0), 0);
      const now = isGone()
        ? `The table was taken away ${plural(since.value, "second")} ago.`
        : "The table stands in the corridor.";
      const verdict =
        left > 0
          ? `${plural(left, "lethal cell")} of it ${left === 1 ? "is" : "are"} in ${WHERE[placeOfTable.value]}`
          : "None of its cells is left";
      const extra = tablePlan.value.path
        ? `and the path is ${written(Math.max(0, tablePlan.value.length - freePlan.value.length), 2)} m longer than without it`
        : "and there is no path";
      const forgotten =
        placeOfTable.value === "dynamic" && left > 0 && isGone()
          ? ` Forgotten in ${written(tableLifetime.value - since.value + 1, 0)} s.`
          : "";
      return `${now} ${verdict}, ${extra}.${forgotten}`;
    },
    task: "Drag the robot towards it.",
  });
