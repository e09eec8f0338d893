import { computed, useSignal } from "@preact/signals";
import { useId, useMemo, useRef } from "preact/hooks";
import { bresenhamSteps, type Fixes, type Line, octant } from "../../grid/bresenham";
import type { Cell } from "../../grid/lattice";
import type { GridGeometry } from "../../grid/occupancyGrid";
import { amanatidesWoo } from "../../grid/textbook";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { keyedIndex } from "../../ui/seek";
import { Toggle, ToggleOf } from "../../ui/Toggle";
import type { Point } from "../../wire/protocol";
import { DragHandle } from "../common/DragHandle";
import { PlayButton } from "../common/PlayButton";
import { Stage, type StageTransform } from "../common/Stage";
import { useSeen, useSteps } from "../common/useSteps";
import { rayFrom as from, rayTo as to } from "./Worked";
import "./rays.css";

/** Cells of one unit: the figure counts in cells, not in metres. */
const GEOMETRY: GridGeometry = { resolution: 1, rows: 15, cols: 27, origin: [0, 0, 0] };

const inside = ([x, y]: Point): Point => [
  Math.min(GEOMETRY.cols - 0.02, Math.max(0.02, x)),
  Math.min(GEOMETRY.rows - 0.02, Math.max(0.02, y)),
];
const cellOf = ([x, y]: Point): Cell => ({ row: Math.floor(y), col: Math.floor(x) });
const named = ([x, y]: Point): string => `column ${Math.floor(x)}, row ${Math.floor(y)}`;

/** Bresenham's line, step by step, between two points that can be dragged; and the exact traversal beside it. */
export function Rays() {
  const fixes = useSignal<Fixes>({ direction: true, steep: true });
  const exact = useSignal(false);
  const step = useSignal(9);
  const playing = useSignal(false);
  const root = useRef<HTMLElement>(null);
  const line = useMemo(
    () => computed(() => bresenhamSteps(cellOf(from.value), cellOf(to.value), fixes.value)),
    [fixes],
  );
  const crossed = useMemo(() => computed(() => amanatidesWoo(from.value, to.value)), []);
  const last = line.value.steps.length - 1;
  const at = Math.min(step.value, last);
  const go = (next: number): void => {
    step.value = Math.min(line.peek().steps.length - 1, Math.max(0, next));
  };
  useSteps(
    playing,
    useSeen(root),
    () => 420,
    () => {
      const end = line.peek().steps.length - 1;
      if (step.peek() >= end) playing.value = false;
      else go(step.peek() + 1);
    },
  );
  const fix = (name: keyof Fixes) => (on: boolean) => {
    fixes.value = { ...fixes.peek(), [name]: on };
    step.value = Number.MAX_SAFE_INTEGER;
  };
  return (
    <figure class="rays stack" ref={root} aria-label="Bresenham’s line on a grid, step by step">
      <Stage geometry={GEOMETRY} label={`The line’s cells from ${named(from.value)} to ${named(to.value)}`} lines>
        {(transform) => (
          <>
            <Cells transform={transform} line={line.value} at={at} />
            {exact.value && <Crossed transform={transform} cells={crossed.value} />}
            <line
              class="rays-beam"
              x1={transform.x(from.value[0])}
              y1={transform.y(from.value[1])}
              x2={transform.x(to.value[0])}
              y2={transform.y(to.value[1])}
            />
            <DragHandle
              transform={transform}
              at={from.value}
              label="First cell of the line"
              sentence="Moves the cell of the sensor, in which the line begins."
              text={named(from.value)}
              step={1}
              onMove={(point) => {
                from.value = inside(point);
              }}
            />
            <DragHandle
              transform={transform}
              at={to.value}
              label="Last cell of the line"
              sentence="Moves the cell in which the beam ends; the eight octants lie around the sensor."
              text={named(to.value)}
              tone="beam"
              step={1}
              onMove={(point) => {
                to.value = inside(point);
              }}
            />
          </>
        )}
      </Stage>
      <Nablas line={line.value} at={at} onGo={go} />
      <div class="rays-controls no-print">
        <Button icon="stepBack" label="Back one cell" onClick={() => go(at - 1)} />
        <PlayButton
          playing={playing}
          onPress={() => {
            if (at >= last) step.value = 0;
          }}
        />
        <Button icon="stepForward" label="Forward one cell" onClick={() => go(at + 1)} />
        <Toggle label="fix 1: step with the signs" checked={fixes.value.direction} onChange={fix("direction")} />
        <Toggle label="fix 2: swap steep axes" checked={fixes.value.steep} onChange={fix("steep")} />
        <ToggleOf label="exact traversal" signal={exact} />
      </div>
      <figcaption aria-live="polite">
        <Words
          line={line.value}
          at={at}
          from={cellOf(from.value)}
          to={cellOf(to.value)}
          crossed={exact.value ? crossed.value.length : 0}
        />
      </figcaption>
    </figure>
  );
}

function Cells({ transform, line, at }: { transform: StageTransform; line: Line; at: number }) {
  return (
    <>
      {line.steps.map(({ cell }, i) => (
        <rect
          key={`${cell.row} ${cell.col}`}
          class={`rays-cell ${i < at ? "done" : i === at ? "now" : "ahead"}`}
          x={cell.col * transform.cell}
          y={transform.height - (cell.row + 1) * transform.cell}
          width={transform.cell}
          height={transform.cell}
        />
      ))}
    </>
  );
}

function Crossed({ transform, cells }: { transform: StageTransform; cells: readonly Cell[] }) {
  const inset = Math.max(1.5, transform.cell * 0.1);
  return (
    <>
      {cells.map(({ row, col }) => (
        <rect
          key={`${row} ${col}`}
          class="rays-crossed"
          x={col * transform.cell + inset}
          y={transform.height - (row + 1) * transform.cell + inset}
          width={transform.cell - 2 * inset}
          height={transform.cell - 2 * inset}
        />
      ))}
    </>
  );
}

const CHART = { width: 720, height: 92, left: 34, middle: 46 };

/** ∇ at every cell as a bar: at or above zero the next step is diagonal. A click selects a bar. */
function Nablas({ line, at, onGo }: { line: Line; at: number; onGo: (step: number) => void }) {
  const id = useId();
  const count = Math.max(1, line.steps.length);
  const wide = (CHART.width - CHART.left) / Math.max(count, 12);
  const most = Math.max(1, ...line.steps.map(({ nabla }) => Math.abs(nabla ?? 0)));
  const choose = (event: PointerEvent): void => {
    const bounds = (event.currentTarget as Element).getBoundingClientRect();
    onGo(Math.floor((((event.clientX - bounds.left) / bounds.width) * CHART.width - CHART.left) / wide));
  };
  const tall = (nabla: number): number => ((CHART.middle - 6) * nabla) / most;
  return (
    <div
      class="rays-nablas"
      role="slider"
      tabIndex={0}
      aria-label="Step of the line"
      aria-describedby={id}
      aria-valuenow={at + 1}
      aria-valuemin={1}
      aria-valuemax={line.steps.length}
      aria-valuetext={`cell ${at + 1} of ${line.steps.length}, ∇ ${line.steps[at]?.nabla ?? "at the end"}`}
      onPointerDown={choose}
      onPointerMove={(event) => {
        if (event.buttons === 1) choose(event);
      }}
      onKeyDown={(event) => {
        const next = keyedIndex(event.key, event.shiftKey, at, line.steps.length - 1);
        if (next === null) return;
        event.preventDefault();
        onGo(next);
      }}
    >
      <span id={id} hidden>
        Steps through the cells of the line and shows ∇ at each of them.
      </span>
      <svg viewBox={`0 0 ${CHART.width} ${CHART.height}`} role="presentation">
        <text class="axis-title" x={8} y={CHART.middle + 8}>
          ∇
        </text>
        <line class="zero" x1={CHART.left} x2={CHART.width} y1={CHART.middle} y2={CHART.middle} />
        {line.steps.map(({ cell, nabla }, i) =>
          nabla === null ? null : (
            <g key={`${cell.row} ${cell.col}`} class={i === at ? "now" : ""}>
              <rect
                class={nabla >= 0 ? "diagonal" : "straight"}
                x={CHART.left + i * wide + 2}
                y={CHART.middle - Math.max(0, tall(nabla)) - (nabla === 0 ? 2 : 0)}
                width={Math.max(2, Math.min(wide - 4, 40))}
                height={Math.max(2, Math.abs(tall(nabla)))}
              />
            </g>
          ),
        )}
      </svg>
    </div>
  );
}

interface WordsProps {
  readonly line: Line;
  readonly at: number;
  readonly from: Cell;
  readonly to: Cell;
  readonly crossed: number;
}

function Words({ line, at, from, to, crossed }: WordsProps) {
  const step = line.steps[at];
  const end = line.steps.at(-1)?.cell;
  const arrived = end?.row === to.row && end.col === to.col;
  const { nabla } = step ?? { nabla: null };
  return (
    <>
      Octant {octant(from, to)}: dx = {written(line.dx, 0)}, dy = {written(line.dy, 0)}
      {line.steep && ", axes swapped"}.{" "}
      {nabla === null ? (
        arrived ? (
          "The last cell: the beam ends here."
        ) : (
          <b class="noun-hit">
            The line stops at column {end?.col}, row {end?.row}, and the beam ends at column {to.col}, row {to.row}: a
            fix is missing.
          </b>
        )
      ) : (
        <>
          Cell {at + 1} of {line.steps.length}: ∇ = <b>{written(nabla, 0)}</b>{" "}
          {nabla >= 0 ? (
            <>
              ≥ 0, so <b class="noun-hit">diagonal</b>, then ∇ + 2dy − 2dx ={" "}
            </>
          ) : (
            <>
              &lt; 0, so <b class="noun-miss">straight</b>, then ∇ + 2dy ={" "}
            </>
          )}
          {written(nabla + (nabla >= 0 ? 2 * line.dy - 2 * line.dx : 2 * line.dy), 0)}.
        </>
      )}
      {crossed > 0 && ` The beam itself crosses ${crossed} cells; Bresenham’s line has ${line.steps.length}.`}
    </>
  );
}
