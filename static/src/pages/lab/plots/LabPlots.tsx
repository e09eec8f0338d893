/** Quantities of the lab over time, from when the view was opened. */

import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import UPlot from "uplot";
import { logOddsAt, probability, thresholds } from "../../../grid/cellValues";
import { type Cells, NEVER } from "../../../render/map/cells";
import type { MapPicture } from "../../../render/map/mapPicture";
import { CHUNK } from "../../../render/map/pyramid";
import type { Store } from "../../../store/store";
import { isDark } from "../../../ui/browser/theme";
import { useWidth } from "../../../ui/browser/useSize";
import { written } from "../../../ui/numbers";
import { type FrameMessage, type Geometry, TILE } from "../../../wire/protocol";
import { axisStyle, colourOf, labelsOn, numberLabels, timeAxis } from "../../logs/contents/plotParts";
import "uplot/dist/uPlot.min.css";
import "../stage.css";

/** Number of samples kept: five minutes at ten scans per second. */
const MOST = 3000;
/** Number of oldest samples removed at once, so that few samples are copied. */
const DROPPED = 500;

/** The entropy of a cell in bits by its byte; cells that were never observed do not count. */
export function bitsOfBytes(range: Pick<Geometry, "low" | "high">): Float64Array {
  return Float64Array.from({ length: 256 }, (_, byte) => {
    const p = byte === NEVER ? 0 : probability(logOddsAt(byte, range));
    return p > 0 && p < 1 ? -p * Math.log2(p) - (1 - p) * Math.log2(1 - p) : 0;
  });
}

interface KeptTile {
  readonly tx: number;
  readonly ty: number;
  bits: number;
  /** 0 unknown, 1 free, 2 occupied. */
  readonly states: Uint8Array;
}

/** Follows the cells of one map: its entropy, and the number of changes between unknown, free and occupied. */
export class MapWatch {
  readonly #cells: Cells;
  readonly #bits: Float64Array;
  readonly #states: Uint8Array;
  readonly #tiles = new Map<string, KeptTile>();
  readonly #waiting = new Map<string, readonly [tx: number, ty: number]>();
  readonly #bytes = new Uint8Array(TILE * TILE);
  readonly #note = (tx: number, ty: number): void => {
    this.#waiting.set(`${tx} ${ty}`, [tx, ty]);
  };

  constructor({ cells, geometry }: MapPicture) {
    const { below, above } = thresholds(geometry);
    this.#cells = cells;
    this.#bits = bitsOfBytes(geometry);
    this.#states = Uint8Array.from({ length: 256 }, (_, byte) =>
      byte === NEVER ? 0 : byte < below ? 1 : byte > above ? 2 : 0,
    );
    const side = CHUNK / TILE;
    for (const { row, col } of cells.chunks()) {
      for (let k = 0; k < side * side; k++) this.#note(col * side + (k % side), row * side + Math.floor(k / side));
    }
    cells.listeners.add(this.#note);
    this.look();
  }

  /**
   * The entropy of the observed cells in bits, and the number of cells that changed their state since the last call.
   */
  look(): { readonly bits: number; readonly changed: number } {
    let changed = 0;
    for (const [key, [tx, ty]] of this.#waiting) {
      const tile = this.#tiles.get(key) ?? { tx, ty, bits: 0, states: new Uint8Array(TILE * TILE) };
      this.#tiles.set(key, tile);
      this.#cells.readTile(tx, ty, this.#bytes);
      tile.bits = 0;
      for (let i = 0; i < this.#bytes.length; i++) {
        const byte = this.#bytes[i] as number;
        const state = this.#states[byte] as number;
        tile.bits += this.#bits[byte] as number;
        if (state !== tile.states[i]) changed++;
        tile.states[i] = state;
      }
    }
    this.#waiting.clear();
    let bits = 0;
    for (const tile of this.#tiles.values()) bits += tile.bits;
    return { bits, changed };
  }

  /** Whether cells were set since the last call. */
  get isBehind(): boolean {
    return this.#waiting.size > 0;
  }

  stop(): void {
    this.#cells.listeners.delete(this.#note);
  }
}

/** Names of the plotted quantities, in the order of {@link Samples.columns}, with their units. */
const PLOTTED = [
  { label: "Entropy of the map", unit: "bit" },
  { label: "Cells changed", unit: "cells" },
  { label: "Error of the belief", unit: "m" },
  { label: "Speed", unit: "m/s" },
] as const;

type Numbers = (number | null)[];

/** The samples so far. */
export class Samples {
  readonly times: number[] = [];
  readonly columns: readonly [bits: Numbers, changed: Numbers, error: Numbers, speed: Numbers] = [[], [], [], []];
  #watch: MapWatch | null = null;
  #watched: MapPicture | null = null;
  #before: Pick<FrameMessage, "stamp" | "pose"> | null = null;

  /**
   * Add a sample for a frame and the map, or correct that of the frame if the map has changed since, because tiles come
   * after their frame. Returns whether anything changed.
   */
  take(frame: Pick<FrameMessage, "stamp" | "pose" | "believed_pose">, map: MapPicture): boolean {
    const before = this.#before;
    const isSame = this.#watched === map;
    if (before?.stamp === frame.stamp && isSame && !this.#watch?.isBehind) return false;
    // A restart, another world, or scans that were removed from the map.
    if (before && frame.stamp < before.stamp) this.clear();
    if (!isSame) {
      this.#watch?.stop();
      this.#watch = new MapWatch(map);
      this.#watched = map;
    }
    const { bits, changed } = (this.#watch as MapWatch).look();
    if (before?.stamp === frame.stamp) {
      const [entropies, changes] = this.columns;
      const last = this.times.length - 1;
      entropies[last] = bits;
      if (typeof changes[last] === "number") changes[last] += changed;
      return true;
    }
    const [x, y] = frame.believed_pose ?? frame.pose;
    const last = this.#before;
    this.times.push(frame.stamp);
    const row = [
      bits,
      isSame ? changed : null,
      Math.hypot(x - frame.pose[0], y - frame.pose[1]),
      last && Math.hypot(frame.pose[0] - last.pose[0], frame.pose[1] - last.pose[1]) / (frame.stamp - last.stamp),
    ];
    for (const [n, column] of this.columns.entries()) column.push(row[n] ?? null);
    if (this.times.length > MOST) for (const all of [this.times, ...this.columns]) all.splice(0, DROPPED);
    this.#before = { stamp: frame.stamp, pose: frame.pose };
    return true;
  }

  clear(): void {
    for (const all of [this.times, ...this.columns]) all.length = 0;
    this.#before = null;
  }

  stop(): void {
    this.#watch?.stop();
  }
}

const HEIGHT = 84;
/** Interval of painting: that of scans at normal speed. */
const EVERY_MS = 100;
const TONES = ["--miss", "--hit", "--robot", "--beam"] as const;

export function LabPlots({ store }: { readonly store: Store }) {
  const samples = useMemo(() => new Samples(), [store]);
  const version = useSignal(0);
  useEffect(() => {
    let painted = 0;
    let request = 0;
    // The cells of a scan follow its frame and arrive by the next animation frame.
    const look = (now: number): void => {
      request = requestAnimationFrame(look);
      const [frame, map] = [store.frame.peek(), store.map.peek()];
      if (!frame || !map || now - painted < EVERY_MS || !samples.take(frame, map)) return;
      painted = now;
      version.value++;
    };
    request = requestAnimationFrame(look);
    return () => {
      cancelAnimationFrame(request);
      samples.stop();
    };
  }, [samples]);
  void version.value;
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
    <div class="lab-plots" tabIndex={0}>
      {PLOTTED.map(({ label, unit }, n) => (
        <Line key={label} samples={samples} version={version.value} column={n} label={label} unit={unit} />
      ))}
    </div>
  );
}

interface LineProps {
  readonly samples: Samples;
  /** Changes with the samples. */
  readonly version: number;
  readonly column: number;
  readonly label: string;
  readonly unit: string;
}

function Line({ samples, version, column, label, unit }: LineProps) {
  const frame = useRef<HTMLDivElement>(null);
  const drawn = useRef<UPlot | null>(null);
  const width = useWidth(frame, 360).value;
  const scheme = isDark.value;
  const values = samples.columns[column] ?? [];
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const axis = axisStyle(element);
    const chart = new UPlot(
      {
        width,
        height: HEIGHT,
        padding: [6, 8, 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26, ...timeAxis(60, null) },
          { ...axis, size: 52, splits: labelsOn(22), values: (_, splits) => numberLabels(splits) },
        ],
        series: [
          {},
          { stroke: colourOf(element, TONES[column] ?? "--foreground"), width: 1.5, points: { show: false } },
        ],
      },
      [samples.times, values],
      element,
    );
    drawn.current = chart;
    return () => {
      drawn.current = null;
      chart.destroy();
    };
  }, [samples, scheme]);
  useEffect(() => {
    drawn.current?.setSize({ width, height: HEIGHT });
  }, [width]);
  useEffect(() => {
    drawn.current?.setData([samples.times, values]);
  }, [version]);
  const now = values.findLast((value) => value !== null);
  return (
    <figure class="lab-plot" data-plot={label}>
      <figcaption>
        {label} <span class="number">{now == null ? "–" : `${written(now, unit === "cells" ? 0 : 2)} ${unit}`}</span>
      </figcaption>
      <div ref={frame} role="img" aria-label={`${label} over time, ${unit}`} />
    </figure>
  );
}
