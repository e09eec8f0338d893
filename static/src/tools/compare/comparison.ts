/** The comparison of two maps in one picture: its view mode, and the layers drawn. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { CombinedMap, type CommonLattice, commonLattice, mergedCodes, whyNoMerge } from "../../render/map/combinedMap";
import { DIFFERENCE, differenceCodes, MARKS, type Marked, markedCodes } from "../../render/map/difference";
import type { MapPicture } from "../../render/map/mapPicture";
import type { Layer } from "../../render/map/renderer";
import { toScreen } from "../../render/view";
import { MAP, SECOND_MAP } from "../../store/layers";
import type { Store } from "../../store/store";
import { reducedMotion } from "../../ui/browser/media";
import type { Point } from "../../wire/protocol";

/** A left and B right of a divider; A and B alternating; their difference; their sum. */
export type ViewMode = "swipe" | "blink" | "difference" | "merge";
export const VIEW_MODES: readonly ViewMode[] = ["swipe", "blink", "difference", "merge"];

/** Seconds for which each map is shown while they blink: never more than one flash in two seconds. */
export const BLINK_S = [1, 1.5, 2, 3] as const;

interface Pair {
  readonly a: MapPicture;
  readonly b: MapPicture;
  readonly lattice: CommonLattice | null;
}

/** Shows the second map of a session in the picture of the first, if there is one. */
export class Comparison {
  readonly mode = signal<ViewMode>("swipe");
  /** Position of the divider, 0 to 1 of the picture's width. */
  readonly divider = signal(0.5);
  readonly blinkS = signal<number>(1);
  /** Whether the maps alternate automatically. */
  readonly blinks = signal(!reducedMotion.peek());
  /** Which of the two is shown while they blink. */
  readonly shown = signal<"a" | "b">("a");
  /** Whether A has a separate picture, so that the picture of B shows only B. */
  readonly isApart = signal(false);
  readonly marked = signal<Marked | null>(null);
  /** Whether the session compares its map. */
  readonly isOn: ReadonlySignal<boolean>;
  readonly pair: ReadonlySignal<Pair | null>;
  /** Why A and B cannot be added; null if they can. */
  readonly noMerge: ReadonlySignal<string | null>;
  /** The log-odds prior, which the sum of both maps counts once, while the sum is displayed; null otherwise. */
  readonly summedOver: ReadonlySignal<number | null>;
  readonly #store: Store;
  readonly #difference: ReadonlySignal<CombinedMap | null>;
  readonly #merge: ReadonlySignal<CombinedMap | null>;
  readonly #marks: ReadonlySignal<CombinedMap | null>;

  constructor(store: Store) {
    this.#store = store;
    this.isOn = computed(() => store.compared.value !== null);
    this.pair = computed(() => {
      const a = store.second.value?.map.value;
      const b = store.map.value;
      return a && b ? { a, b, lattice: commonLattice(a.geometry, b.geometry) } : null;
    });
    this.#difference = this.#combined(() =>
      this.mode.value === "difference" ? (a, b) => differenceCodes(a.geometry, b.geometry) : null,
    );
    this.noMerge = computed(() => {
      const now = store.mapping.values.value;
      return whyNoMerge({ ...now, ...store.compared.value?.values }, now);
    });
    this.summedOver = computed(() =>
      this.mode.value === "merge" && this.noMerge.value === null
        ? Number(store.mapping.values.value.log_odds_prior)
        : null,
    );
    this.#merge = this.#combined(() => {
      const prior = this.summedOver.value;
      return prior === null ? null : (a, b) => mergedCodes(a.geometry, b.geometry, prior);
    });
    this.#marks = this.#combined(() => {
      const marked = this.marked.value;
      return marked && ((a, b) => markedCodes(a.geometry, b.geometry, marked));
    });
  }

  /** The cells that `codes` computes from both maps; null if there are none, or the maps have no common lattice. */
  #combined(codes: () => ((a: MapPicture, b: MapPicture) => Uint8Array) | null): ReadonlySignal<CombinedMap | null> {
    let last: CombinedMap | null = null;
    return computed(() => {
      last?.dispose();
      const pair = this.pair.value;
      const make = codes();
      last =
        make && pair?.lattice ? new CombinedMap(pair.a.cells, pair.b.cells, pair.lattice, make(pair.a, pair.b)) : null;
      return last;
    });
  }

  /** Subscribe to the second map while there is one, and make the maps blink. The result stops it. */
  start(): () => void {
    const store = this.#store;
    const stops = [
      effect(() => {
        if (!this.isOn.value) return;
        const leave = store.layers.subscribe(SECOND_MAP);
        store.second.value = store.layers.grid(SECOND_MAP);
        return () => {
          leave();
          store.second.value = null;
          store.part("comparison").message.value = null;
          store.inspectedSecond.value = null;
          if (store.explainedLayer.peek() === SECOND_MAP) store.explain(store.explainedPoint.peek(), MAP);
        };
      }),
      effect(() => {
        if (!this.isOn.value || this.mode.value !== "blink" || !this.blinks.value) return;
        const turn = (): void => this.turn();
        const timer = setInterval(turn, 1000 * this.blinkS.value);
        return () => clearInterval(timer);
      }),
    ];
    store.mapAt = (point) => this.mapAt(point);
    return () => {
      for (const stop of stops) stop();
      this.#difference.peek()?.dispose();
      this.#merge.peek()?.dispose();
      this.#marks.peek()?.dispose();
      store.mapAt = null;
    };
  }

  /** Show the other of the two maps. */
  turn(): void {
    this.shown.value = this.shown.peek() === "a" ? "b" : "a";
  }

  /** The fraction of the picture's width, from the left, that shows A. */
  get share(): number {
    if (!this.pair.peek() || this.isApart.peek()) return 0;
    if (this.mode.peek() === "blink") return this.shown.peek() === "a" ? 1 : 0;
    return this.mode.peek() === "swipe" ? this.divider.peek() : 0;
  }

  /** The layer displayed at a point of the world. */
  mapAt(point: Point): string {
    const view = this.#store.view.peek();
    const size = [...this.#store.pictures.values()][0];
    if (!view || !size) return MAP;
    return toScreen(view, size, point[0], point[1])[0] < this.share * size.width ? SECOND_MAP : MAP;
  }

  /** Read every signal that the picture shows. */
  watch(): void {
    void [
      this.isOn.value,
      this.isApart.value,
      this.mode.value,
      this.divider.value,
      this.shown.value,
      this.marked.value,
    ];
    void [this.pair.value, this.noMerge.value, this.#store.second.value?.version.value];
  }

  layers(): readonly Layer[] {
    const pair = this.pair.peek();
    if (!pair || this.isApart.peek()) return [{ map: this.#store.map.peek(), hasHighlights: true }];
    const { a, b, lattice } = pair;
    const layers: Layer[] = [];
    const difference = this.#difference.peek();
    const merge = this.#merge.peek();
    if (difference && lattice) {
      layers.push({
        map: { geometry: lattice.geometry, cells: difference.update(), style: b.style },
        palette: DIFFERENCE,
      });
    } else if (merge && lattice) {
      layers.push({ map: { geometry: lattice.geometry, cells: merge.update(), style: b.style } });
    } else {
      layers.push({ map: b, part: [this.share, 1], hasHighlights: true }, { map: a, part: [0, this.share] });
    }
    const marks = this.#marks.peek();
    if (marks && lattice)
      layers.push({
        map: { geometry: lattice.geometry, cells: marks.update(), style: b.style },
        palette: MARKS,
        blends: true,
      });
    return layers;
  }

  /**
   * The part of the picture in which B's trajectory and beams are drawn: all of it if both maps have the same poses,
   * none over a difference or a sum.
   */
  ownPart(): readonly [from: number, to: number] {
    const compared = this.#store.compared.peek();
    if (!compared || !this.pair.peek() || this.isApart.peek()) return [0, 1];
    if (this.mode.peek() === "difference" || this.mode.peek() === "merge") return [1, 1];
    // The correct map of a simulation has the true poses: the same unless the believed ones differ.
    const areTrue = compared.with_faults || !this.#store.frame.peek()?.believed_pose;
    const samePoses = areTrue && !compared.log && compared.trajectory === this.#store.trajectory.peek()?.name;
    return samePoses ? [0, 1] : [this.share, 1];
  }
}
