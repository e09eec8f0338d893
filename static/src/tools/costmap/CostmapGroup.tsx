/** The costmap of the lab's robot: its layers as sheets, their parameters, and the robot's outline. */

import { useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useMemo, useRef } from "preact/hooks";
import { CostCurve as Curve } from "../../render/chart/CostCurve";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { zoomOf } from "../../ui/browser/useSize";
import { OpenFiles } from "../../ui/files/OpenFiles";
import { saveAs } from "../../ui/files/saveAs";
import { type Range, written } from "../../ui/numbers";
import { ROBOT_RADIUS } from "../../wire/constants";
import type { Point } from "../../wire/protocol";
import { ParameterRows } from "../parameters/ParameterRows";
import { Begin, End, useCostmap, useRows } from "./BeginEnd";
import { CostFiles } from "./CostFiles";
import { crossingOf, OUTLINES, rounded } from "./footprint";
import { Sheets } from "./Sheets";
import { costmapOf } from "./state";
import { OverChoice } from "./Tools";
import { WhyCost } from "./WhyCost";
import "./costmap.css";

const SIZE = 190;
const STEP = 0.01;
const FARTHEST = 0.95;
const STEPS: Readonly<Record<string, Point>> = {
  ArrowLeft: [-STEP, 0],
  ArrowRight: [STEP, 0],
  ArrowUp: [0, STEP],
  ArrowDown: [0, -STEP],
};

export function Outline({ store }: { readonly store: Store }) {
  const costmap = costmapOf(store).costmap.value;
  const sketch = useSignal<readonly Point[] | null>(null);
  const held = useRef<{ corner: number; at: Point; from: Point } | null>(null);
  if (!costmap) return null;
  const corners = sketch.value ?? costmap.footprint;
  const farthest = Math.max(0.3, ...costmap.footprint.flat().map(Math.abs));
  const scale = (SIZE / 2 - 16) / farthest;
  const at = ([x, y]: Point): Point => [SIZE / 2 + scale * x, SIZE / 2 - scale * y];
  const move = (corner: number, to: Point): void => {
    const inside = to.map((v) => rounded(Math.min(FARTHEST, Math.max(-FARTHEST, v)))) as unknown as Point;
    const next = corners.map((point, i) => (i === corner ? inside : point));
    if (held.current) sketch.value = next;
    costmapOf(store).setFootprint(next);
  };
  const release = (): void => {
    held.current = null;
    sketch.value = null;
  };
  return (
    <figure class="outline" aria-label="Outline of the robot, seen from above">
      <svg role="presentation" width={SIZE} height={SIZE}>
        <circle class="body" cx={SIZE / 2} cy={SIZE / 2} r={scale * ROBOT_RADIUS} />
        <circle class="circumscribed" cx={SIZE / 2} cy={SIZE / 2} r={scale * costmap.circumscribed_radius} />
        <circle class="inscribed" cx={SIZE / 2} cy={SIZE / 2} r={scale * costmap.inscribed_radius} />
        <polygon class="shape" points={corners.map((corner) => at(corner).join(",")).join(" ")} />
        <path class="heading" d={`M${SIZE / 2} ${SIZE / 2}h${scale * ROBOT_RADIUS}`} />
        {corners.map((corner, n) => {
          const [x, y] = at(corner);
          return (
            // biome-ignore lint/a11y/useSemanticElements: SVG has no buttons
            <g
              key={n}
              class="handle corner"
              role="button"
              tabindex={0}
              aria-label={`Corner ${n + 1} of ${corners.length}: ${written(corner[0], 2)} m ahead, ${written(corner[1], 2)} m to the left; arrow keys move it`}
              onPointerDown={(event) => {
                if (event.button !== 0) return;
                event.preventDefault();
                event.currentTarget.focus({ preventScroll: true });
                event.currentTarget.setPointerCapture(event.pointerId);
                held.current = { corner: n, at: [event.clientX, event.clientY], from: corner };
              }}
              onPointerMove={(event) => {
                const now = held.current;
                if (!now) return;
                const px = scale * zoomOf(event.currentTarget);
                const [dx, dy] = [(event.clientX - now.at[0]) / px, (event.clientY - now.at[1]) / px];
                move(now.corner, [now.from[0] + dx, now.from[1] - dy]);
              }}
              onPointerUp={release}
              onPointerCancel={release}
              onKeyDown={(event) => {
                const step = STEPS[event.key];
                if (!step) return;
                event.preventDefault();
                move(n, [corner[0] + step[0], corner[1] + step[1]]);
              }}
            >
              <rect class="handle-grab" x={x - 16} y={y - 16} width={32} height={32} />
              <circle class="handle-mark" cx={x} cy={y} r={6} />
            </g>
          );
        })}
      </svg>
      <figcaption>
        <p>Drag the corners of the robot’s outline.</p>
        <div class="actions">
          {OUTLINES.map((outline) => (
            <button
              key={outline.label}
              type="button"
              class="button"
              onClick={() => costmapOf(store).setFootprint(outline.corners)}
            >
              {outline.label}
            </button>
          ))}
        </div>
        <p role="status">{crossingOf(corners)}</p>
      </figcaption>
    </figure>
  );
}

const ROWS = [
  "map",
  "track_unknown_space",
  "clearing",
  "lifetime",
  "obstacle_max_range",
  "speed_filter",
  "speed_limits",
];
const INFLATION = ["inflation_radius", "cost_scaling_factor"];
/** A command has at most 64 KiB. */
const MOST_BYTES = 60_000;

interface CostmapGroupProps {
  readonly store: Store;
  /** Further settings of the layers. */
  readonly children?: ComponentChildren;
}

export function CostmapGroup({ store, children }: CostmapGroupProps) {
  useCostmap(store);
  const rows = useRows(store, ROWS);
  const inflation = useRows(store, INFLATION);
  const set = useMemo(
    () => (name: string, value: number | string | boolean) => store.setPart("costmap", { [name]: value }),
    [store],
  );
  const { costmap, values } = costmapOf(store);
  if (costmap.value?.is_on !== true) return <Begin store={store} />;
  return (
    <div class="navigation stack-narrow">
      <Sheets store={store} />
      <WhyCost store={store} />
      <OverChoice store={store} />
      <h2>Inflation</h2>
      <CostCurve store={store} />
      <div class="navigation-settings">
        <ParameterRows rows={inflation} values={values.values} set={set} />
      </div>
      <Outline store={store} />
      <h2>Layers</h2>
      <div class="navigation-settings">
        <ParameterRows rows={rows} values={values.values} set={set} />
        {children}
      </div>
      <h2>Nav2</h2>
      <Nav2 store={store} />
      <h2>Download the costs</h2>
      <CostFiles session={store.hello.value?.session ?? ""} strokes={costmap.value.keepout} />
      <End store={store} />
    </div>
  );
}

/** The parameters as a Nav2 parameter file, down and up. */
function Nav2({ store }: { readonly store: Store }) {
  const answer = store.part("nav2").message;
  useSignalEffect(() => {
    const text = answer.value?.text ?? null;
    if (text === null) return;
    answer.value = null;
    saveAs("nav2_params.yaml", new Blob([text], { type: "application/yaml" }));
  });
  const upload = async (chosen: File): Promise<void> => {
    if (chosen.size > MOST_BYTES) {
      store.notice.value = {
        kind: "error",
        code: "nav2.too_large",
        message: `The parameter file has ${chosen.size} bytes; at most ${MOST_BYTES} are read.`,
      };
      return;
    }
    store.send({ type: "nav2", text: await chosen.text() });
  };
  return (
    <>
      <p class="navigation-note">
        The parameters as a Nav2 file: costmap, NavFn and Regulated Pure Pursuit; a loaded file with what was changed
        here. Nav2 has no layer with a lifetime: it is left out. Painted zones are filters with a mask of their own
        below: save its files beside the yaml.
      </p>
      <div class="actions">
        <Button icon="download" onClick={() => store.send({ type: "nav2" })}>
          Download yaml
        </Button>
        <OpenFiles label="Nav2 parameter file" accept=".yaml,.yml" onFiles={([chosen]) => void upload(chosen)}>
          Load yaml
        </OpenFiles>
      </div>
    </>
  );
}

/** The curve of the session's costs. */
export function CostCurve({ store }: { readonly store: Store }) {
  const state = costmapOf(store);
  const costmap = state.costmap.value;
  const values = state.values.values.value;
  const table = store.hello.value?.tables.costmap;
  const row = (name: string): Range => table?.find((row) => row.name === name) ?? { low: 0, high: 1, step: 0.1 };
  if (!costmap) return null;
  return (
    <Curve
      inscribed={costmap.inscribed_radius}
      circumscribed={costmap.circumscribed_radius}
      inflation={{
        inflation_radius: Number(values.inflation_radius),
        cost_scaling_factor: Number(values.cost_scaling_factor),
      }}
      ranges={{ inflation_radius: row("inflation_radius"), cost_scaling_factor: row("cost_scaling_factor") }}
      onChange={(name, value) => store.setPart("costmap", { [name]: value })}
    />
  );
}
