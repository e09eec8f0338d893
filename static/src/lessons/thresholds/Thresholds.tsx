import { computed, type Signal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import { bound } from "../../ui/bound";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Plot } from "../common/Plot";
import { Stage } from "../common/Stage";
import { ValueHandle } from "../common/ValueHandle";
import { counted, GEOMETRY, greysOf, MAP, pgmHeader, readValue, STATED, yamlText } from "./model";
import "./thresholds.css";

const READ_GREY: Record<number, number> = { 100: 0, 0: 254, [-1]: 150 };

/**
 * Two thresholds on a histogram, the resulting image, the map files, and the map as read from them with `readFree`, the
 * free_thresh of the reader.
 */
export function Thresholds({ readFree }: { readonly readFree: Signal<number> }) {
  const occupied = useSignal(0.65);
  const free = useSignal(0.25);
  const map = useSignal(MAP);
  const greys = useMemo(() => computed(() => greysOf(MAP, occupied.value, free.value)), [occupied, free]);
  const readAs = useMemo(
    () => computed(() => greys.value.map((grey) => READ_GREY[readValue(grey, STATED.occupied, readFree.value)] ?? 150)),
    [greys, readFree],
  );
  const written3 = counted(greys.value, STATED.occupied, STATED.free);
  const read = counted(greys.value, STATED.occupied, readFree.value);
  const trap = read.unknown === 0 && written3.unknown > 0;
  return (
    <figure class="thresholds stack" aria-label="Thresholds, the map file, and the map as read from it">
      <div class="side-by-side three">
        <div>
          <h3>Probabilities</h3>
          <Stage geometry={GEOMETRY} label="Probabilities of a small map" grid={map} />
        </div>
        <div>
          <h3>map.pgm</h3>
          <Stage geometry={GEOMETRY} label="The image: black occupied, white free, grey unknown" greys={greys} />
        </div>
        <div>
          <h3>As read from the file</h3>
          <Stage geometry={GEOMETRY} label="The map as read from the image" greys={readAs} />
        </div>
      </div>
      <Plot height={HEIGHT}>
        {(width) => (
          <Histogram
            width={width}
            free={free.value}
            occupied={occupied.value}
            set={(which, value) => {
              if (which === "free") free.value = Math.min(value, occupied.peek());
              else occupied.value = Math.max(value, free.peek());
            }}
          />
        )}
      </Plot>
      <p class="number" aria-live="polite">
        <b class="noun-miss">{written3.free} free</b>, <b class="noun-prior">{written3.unknown} unknown</b>,{" "}
        <b class="noun-hit">{written3.occupied} occupied</b> cells are written. The reader gets {read.free} free,{" "}
        {read.unknown} unknown, {read.occupied} occupied.
        {trap && <b class="noun-hit"> All unknown cells are read as free.</b>}
      </p>
      <div class="thresholds-files">
        <div>
          <h3>map.yaml</h3>
          <pre>{yamlText(GEOMETRY, "map.pgm")}</pre>
        </div>
        <div>
          <h3>map.pgm: the header and some of the bytes as numbers</h3>
          <pre>
            {pgmHeader(GEOMETRY)}
            {rowsOf(greys.value)}
          </pre>
        </div>
      </div>
      <div class="figure-controls no-print">
        <Slider
          label="free_thresh of the reader"
          sentence="A cell below this occupancy is read as free; the grey of an unknown cell is read as 0.196."
          {...bound(readFree)}
          initial={STATED.free}
          low={0.1}
          high={0.3}
          step={0.002}
        />
      </div>
    </figure>
  );
}

/** A few bytes of the rows in the middle of the image. */
function rowsOf(greys: Uint8Array): string {
  const { cols } = GEOMETRY;
  return [2, 3, 4, 5]
    .map((row) => [...greys.slice(row * cols + 2, row * cols + 9)].map((grey) => String(grey).padStart(3)).join(" "))
    .map((line) => `… ${line} …`)
    .join("\n");
}

const HEIGHT = 150;
const BINS = 50;
/** The part of a bin's width that its bar takes; the rest is the gap between bars. */
const BAR_SHARE = 0.75;
const LEFT = 14;
const BOTTOM = HEIGHT - 26;
const RANGE = { low: 0.02, high: 0.98, step: 0.01 };
/** Width of each threshold's flag, pixels. */
const FLAG = { free: 88, occupied: 124 } as const;

const BARS: readonly number[] = (() => {
  const bins = new Array<number>(BINS).fill(0);
  MAP.logOdds.forEach((l, i) => {
    if (MAP.observed[i] !== 1) return;
    const bin = Math.min(BINS - 1, Math.floor(probability(l) * BINS));
    bins[bin] = (bins[bin] ?? 0) + 1;
  });
  return bins;
})();

interface HistogramProps {
  readonly width: number;
  readonly free: number;
  readonly occupied: number;
  readonly set: (which: "free" | "occupied", value: number) => void;
}

/** How many observed cells have which p, and the two thresholds to drag. */
function Histogram({ width, free, occupied, set }: HistogramProps) {
  const right = width - 14;
  const x = (p: number): number => LEFT + (right - LEFT) * p;
  const most = Math.sqrt(Math.max(...BARS));
  const tall = (count: number): number => ((BOTTOM - 30) * Math.sqrt(count)) / most;
  // Flags on either side of their lines, inside the figure, and never over each other.
  const freeFlag = Math.min(Math.max(0, x(free) - FLAG.free), width - FLAG.free - FLAG.occupied);
  const flags = {
    free: freeFlag,
    occupied: Math.min(Math.max(freeFlag + FLAG.free, x(occupied)), width - FLAG.occupied),
  };
  return (
    <>
      <rect class="zone-miss" x={x(0)} y={24} width={x(free) - x(0)} height={BOTTOM - 24} />
      <rect class="zone-prior" x={x(free)} y={24} width={x(occupied) - x(free)} height={BOTTOM - 24} />
      <rect class="zone-hit" x={x(occupied)} y={24} width={x(1) - x(occupied)} height={BOTTOM - 24} />
      {BARS.map((count, i) =>
        count === 0 ? null : (
          <rect
            key={`${i / BINS}`}
            class="bar"
            x={x((i + (1 - BAR_SHARE) / 2) / BINS)}
            y={BOTTOM - tall(count)}
            width={(BAR_SHARE * (right - LEFT)) / BINS}
            height={tall(count)}
          />
        ),
      )}
      {[0, 0.25, 0.5, 0.75, 1].map((p) => (
        <text key={p} class="tick" x={x(p)} y={HEIGHT - 8} text-anchor={p === 0 ? "start" : p === 1 ? "end" : "middle"}>
          {p === 0 ? "p = 0" : String(p)}
        </text>
      ))}
      {(["free", "occupied"] as const).map((which) => {
        const now = which === "free" ? free : occupied;
        const [start, to] = [flags[which], flags[which] + FLAG[which]];
        const [left, end] = [Math.min(start, x(now) - 8), Math.max(to, x(now) + 8)];
        return (
          <ValueHandle
            key={which}
            label={which === "free" ? "Free below" : "Occupied above"}
            sentence={
              which === "free"
                ? "A cell with a probability below this is written as free."
                : "A cell with a probability above this is written as occupied."
            }
            axis="x"
            tone={which === "free" ? "tone-miss" : "tone-hit"}
            value={now}
            range={RANGE}
            text={`p ${written(now, 2)}`}
            grab={{ x: left, y: 0, width: end - left, height: BOTTOM }}
            perPixel={1 / (right - LEFT)}
            onValue={(value) => set(which, value)}
          >
            <line class="threshold" x1={x(now)} x2={x(now)} y1={20} y2={BOTTOM} />
            <rect class="pill" x={start} y={1} width={FLAG[which]} height={21} rx={10} />
            <text class="pill-text" x={start + FLAG[which] / 2} y={16} text-anchor="middle">
              {which === "free" ? "free" : "occupied"} {written(now, 2)}
            </text>
          </ValueHandle>
        );
      })}
    </>
  );
}
