import { computed, effect, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import {
  beamModel,
  effectiveReading,
  halfWindow,
  INITIAL_PARAMETERS,
  isCone,
  isNoReturn,
  type SensorModelParameters,
} from "../../grid/sensorModel";
import type { Scale } from "../../render/chart/scale";
import { extentFor, type Layout, type Lens, layoutFor, lensFor, lensKeeping, lensSpan } from "./layout";

export type HandleName = "z" | "z-far" | "near" | "far" | "hit" | "miss" | "range_max" | "opening";

interface Extents {
  readonly up: number;
  readonly down: number;
}

/** The reading of a figure without a live beam, metres. */
const EXAMPLE_READING = 4.23;

/** Length of the cone's axis for which the cone up to `point` metres fits into the picture. */
function reachFor(point: number, values: SensorModelParameters, { curve, strip }: Layout): number {
  const shape = (curve.right - curve.left) / (strip.bottom - curve.top);
  const wide = 2.3 * (point + halfWindow(point, values)) * Math.sin(Math.min(values.opening, Math.PI) / 2) * shape;
  return Math.max(0.5, 1.2 * (point + halfWindow(point, values)), wide);
}

const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");

/** State of the profile: the reading, the enlarged part, the axes, and their animation; no markup. */
export class ProfileView {
  readonly width = signal(720);
  /** The height of its container; null if it has its natural height. */
  readonly height = signal<number | null>(null);
  readonly layout: ReadonlySignal<Layout> = computed(() => layoutFor(this.width.value, this.height.value));
  /** Index of the cell under the pointer. */
  readonly hovered = signal<number | null>(null);
  readonly held = signal<HandleName | null>(null);
  /** Whether the pointer is on the figure. The reading is then paused, or handles would move away from the pointer. */
  readonly hasPointer = signal(false);
  readonly values: ReadonlySignal<SensorModelParameters>;
  /** The reading shown, metres; Infinity for no return. */
  readonly z: ReadonlySignal<number>;
  readonly noReturn: ReadonlySignal<boolean>;
  /** Metres on the axis of the whole beam. */
  readonly total = signal(INITIAL_PARAMETERS.range_max);
  readonly lens = signal<Lens>({ start: 0, span: 2.4 });
  /** Metres of a cone's axis that are shown, from the sensor. */
  readonly reach = signal(3);
  readonly extents = signal<Extents>({ up: 1.2, down: 1.2 });

  #pausedReading: number | null | undefined;
  #lensWanted: Lens | null = null;
  #extentsWanted: Extents = { up: 1.2, down: 1.2 };
  #frame = 0;
  #stops: (() => void)[];

  constructor(
    parameters: ReadonlySignal<Readonly<Record<string, unknown>>>,
    readonly reading: ReadonlySignal<number | null | undefined>,
    /** The reading that was set by dragging, metres; null while the figure follows the beam. */
    readonly grabbed: Signal<number | null> = signal(null),
  ) {
    this.values = computed(() => ({ ...INITIAL_PARAMETERS, ...(parameters.value as Partial<SensorModelParameters>) }));
    this.z = computed(() => {
      const live = this.hasPointer.value ? this.#pausedReading : this.reading.value;
      const values = this.values.value;
      if (this.grabbed.value !== null) return effectiveReading(this.grabbed.value, values);
      if (live === undefined) return Math.min(EXAMPLE_READING, 0.6 * values.range_max);
      return effectiveReading(live ?? Number.POSITIVE_INFINITY, values);
    });
    this.noReturn = computed(() => isNoReturn(this.z.value, this.values.value));
    this.#stops = [effect(() => this.#followTotal()), effect(() => this.#aim())];
  }

  /** The pointer enters or leaves the figure. */
  setPointer(isOver: boolean): void {
    if (isOver && !this.hasPointer.peek()) this.#pausedReading = this.reading.peek();
    this.hasPointer.value = isOver;
  }

  dispose(): void {
    for (const stop of this.#stops) stop();
    cancelAnimationFrame(this.#frame);
  }

  /** Distance axis of curve and cells. */
  readonly xScale: ReadonlySignal<Scale> = computed(() => {
    const { start, span } = this.lens.value;
    const { left, right } = this.layout.value.curve;
    if (isCone(this.values.value)) return { low: 0, high: this.reach.value, from: left, to: right };
    return { low: start, high: start + span, from: left, to: right };
  });

  /** Evidence axis. */
  readonly yScale: ReadonlySignal<Scale> = computed(() => {
    const { up, down } = this.extents.value;
    const { top, bottom } = this.layout.value.curve;
    return { low: -down, high: up, from: bottom, to: top };
  });

  /** Distance axis of the whole beam. */
  readonly beamScale: ReadonlySignal<Scale> = computed(() => {
    const { left, right } = this.layout.value.beam;
    return { low: 0, high: this.total.value, from: left, to: right };
  });

  // The axis must not grow while one of its own handles is dragged, or it would move away from the pointer.
  #followTotal(): void {
    const leastTotal = Math.max(1.25 * this.values.value.range_max, 1);
    if (this.held.value === null) this.total.value = leastTotal;
  }

  #aim(): void {
    const held = this.held.value;
    const { range_max, resolution } = this.values.value;
    const window = 2 * halfWindow(Math.min(this.z.value, range_max), this.values.value);
    const point = this.noReturn.value ? range_max : this.z.value;
    const total = this.total.value;
    const now = this.lens.peek();
    const span = lensSpan(resolution, window, total, this.width.value);
    let jump = false;
    if (held === "z") {
      this.#lensWanted = lensKeeping(point, now);
      jump = true;
    } else if (held === null || held === "z-far") {
      this.#lensWanted = lensFor(point, span, total, this.#lensWanted);
    }
    if (held === null || held === "z-far") this.reach.value = reachFor(point, this.values.value, this.layout.value);
    const model = beamModel(this.values.value);
    const needed = { up: extentFor(model.hit), down: extentFor(model.miss) };
    this.#extentsWanted =
      held === null
        ? needed
        : {
            up: Math.max(needed.up, this.#extentsWanted.up),
            down: Math.max(needed.down, this.#extentsWanted.down),
          };
    if (jump && this.#lensWanted) this.lens.value = this.#lensWanted;
    if (this.#frame === 0) this.#step();
  }

  #step(): void {
    this.#frame = 0;
    const lens = this.#lensWanted ?? this.lens.peek();
    const { lens: shownLens, extents: shownExtents } = { lens: this.lens.peek(), extents: this.extents.peek() };
    const { up, down } = this.#extentsWanted;
    const near = (a: number, b: number, scale: number): boolean => Math.abs(a - b) < 0.002 * scale;
    const there =
      near(shownLens.start, lens.start, lens.span) &&
      near(shownLens.span, lens.span, lens.span) &&
      near(shownExtents.up, up, up) &&
      near(shownExtents.down, down, down);
    // If the reading is outside the enlarged part, an animation would show a part of the beam without it.
    const point = this.noReturn.peek() ? this.values.peek().range_max : this.z.peek();
    const far = point < shownLens.start || point > shownLens.start + shownLens.span;
    if (there || reducedMotion.matches) {
      if (shownLens !== lens) this.lens.value = lens;
      if (shownExtents !== this.#extentsWanted) this.extents.value = this.#extentsWanted;
      return;
    }
    const ease = (a: number, b: number): number => a + 0.28 * (b - a);
    this.lens.value = far ? lens : { start: ease(shownLens.start, lens.start), span: ease(shownLens.span, lens.span) };
    this.extents.value = { up: ease(shownExtents.up, up), down: ease(shownExtents.down, down) };
    this.#frame = requestAnimationFrame(() => this.#step());
  }
}
