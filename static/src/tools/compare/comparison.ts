/** Two maps of one place in one picture: how a person looks at them, and what is drawn for that. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { type CommonLattice, commonLattice, Derived } from "../../render/map/derived";
import { DIFFERENCE, differenceCodes, MARKS, type Marked, markedCodes } from "../../render/map/difference";
import type { MapPicture } from "../../render/map/mapPicture";
import { mergedCodes } from "../../render/map/merged";
import type { Layer } from "../../render/map/renderer";
import { toScreen } from "../../render/view";
import { MAP, SECOND_MAP } from "../../store/layers";
import type { Store } from "../../store/store";
import { reducedMotion } from "../../ui/reducedMotion";
import type { Point } from "../../wire/protocol";
import { whyNoMerge } from "./merging";

/** A left and B right of a divider; A and B by turns; what B has otherwise; the evidence of both in one map. */
export type Look = "swipe" | "blink" | "difference" | "merge";
export const LOOKS: readonly Look[] = ["swipe", "blink", "difference", "merge"];

/** Seconds for which each map is shown while they blink: never more than one flash in two seconds. */
export const BLINK_S = [1, 1.5, 2, 3] as const;

interface Pair {
  readonly a: MapPicture;
  readonly b: MapPicture;
  readonly place: CommonLattice | null;
}

/** Shows the second map of a session in the picture of the first, while there is one. */
export class Comparison {
  readonly look = signal<Look>("swipe");
  /** Where the divider is, 0 … 1 of the picture's width. */
  readonly divider = signal(0.5);
  readonly blinkS = signal<number>(1);
  /** Whether the maps take turns by themselves. */
  readonly blinks = signal(!reducedMotion.peek());
  /** Which of the two is shown while they blink. */
  readonly shown = signal<"a" | "b">("a");
  readonly marked = signal<Marked | null>(null);
  /** Whether the session compares its map. */
  readonly isOn: ReadonlySignal<boolean>;
  readonly pair: ReadonlySignal<Pair | null>;
  /** Why A and B cannot be added; null where they can. */
  readonly noMerge: ReadonlySignal<string | null>;
  /** The log-odds prior, which their sum counts once, while it is looked at; null otherwise. */
  readonly summedOver: ReadonlySignal<number | null>;
  readonly #store: Store;
  readonly #difference: ReadonlySignal<Derived | null>;
  readonly #merge: ReadonlySignal<Derived | null>;
  readonly #marks: ReadonlySignal<Derived | null>;

  constructor(store: Store) {
    this.#store = store;
    this.isOn = computed(() => store.compared.value !== null);
    this.pair = computed(() => {
      const a = store.second.value?.map.value;
      const b = store.map.value;
      return a && b ? { a, b, place: commonLattice(a.geometry, b.geometry) } : null;
    });
    this.#difference = this.#derived(() =>
      this.look.value === "difference" ? (a, b) => differenceCodes(a.geometry, b.geometry) : null,
    );
    this.noMerge = computed(() => {
      const now = store.mapping.values.value;
      return whyNoMerge({ ...now, ...store.compared.value?.values }, now);
    });
    this.summedOver = computed(() =>
      this.look.value === "merge" && this.noMerge.value === null
        ? Number(store.mapping.values.value.log_odds_prior)
        : null,
    );
    this.#merge = this.#derived(() => {
      const prior = this.summedOver.value;
      return prior === null ? null : (a, b) => mergedCodes(a.geometry, b.geometry, prior);
    });
    this.#marks = this.#derived(() => {
      const marked = this.marked.value;
      return marked && ((a, b) => markedCodes(a.geometry, b.geometry, marked));
    });
  }

  /** The cells that `codes` make of both maps; null while it makes none, or the maps have no lattice in common. */
  #derived(codes: () => ((a: MapPicture, b: MapPicture) => Uint8Array) | null): ReadonlySignal<Derived | null> {
    let last: Derived | null = null;
    return computed(() => {
      last?.dispose();
      const pair = this.pair.value;
      const make = codes();
      last = make && pair?.place ? new Derived(pair.a.cells, pair.b.cells, pair.place, make(pair.a, pair.b)) : null;
      return last;
    });
  }

  /** Watch the second map while there is one, and let the maps blink; the result stops it. */
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
          store.comparison.value = null;
          store.inspectedSecond.value = null;
          if (store.askedMap.peek() === SECOND_MAP) store.ask(store.asked.peek(), MAP);
        };
      }),
      effect(() => {
        if (!this.isOn.value || this.look.value !== "blink" || !this.blinks.value) return;
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

  /** How much of the picture's width, from the left, shows A. */
  get share(): number {
    if (!this.pair.peek()) return 0;
    if (this.look.peek() === "blink") return this.shown.peek() === "a" ? 1 : 0;
    return this.look.peek() === "swipe" ? this.divider.peek() : 0;
  }

  /** The layer of the map that is seen at a place of the world. */
  mapAt(point: Point): string {
    const view = this.#store.view.peek();
    const size = [...this.#store.pictures.values()][0];
    if (!view || !size) return MAP;
    return toScreen(view, size, point[0], point[1])[0] < this.share * size.width ? SECOND_MAP : MAP;
  }

  /** Read every signal that the picture shows. */
  watch(): void {
    void [this.isOn.value, this.look.value, this.divider.value, this.shown.value, this.marked.value];
    void [this.pair.value, this.noMerge.value, this.#store.second.value?.version.value];
  }

  layers(): readonly Layer[] {
    const pair = this.pair.peek();
    if (!pair) return [{ map: this.#store.map.peek(), hasHighlights: true }];
    const { a, b, place } = pair;
    const layers: Layer[] = [];
    const difference = this.#difference.peek();
    const merge = this.#merge.peek();
    if (difference && place) {
      layers.push({
        map: { geometry: place.geometry, cells: difference.update(), style: b.style },
        palette: DIFFERENCE,
      });
    } else if (merge && place) {
      layers.push({ map: { geometry: place.geometry, cells: merge.update(), style: b.style } });
    } else {
      layers.push({ map: b, part: [this.share, 1], hasHighlights: true }, { map: a, part: [0, this.share] });
    }
    const marks = this.#marks.peek();
    if (marks && place)
      layers.push({
        map: { geometry: place.geometry, cells: marks.update(), style: b.style },
        palette: MARKS,
        blends: true,
      });
    return layers;
  }

  /**
   * The part of the picture that what belongs to B alone may be drawn over: its robot's way, its beams. Where both maps
   * have the same poses it is all of it; over a difference it would only be in the way.
   */
  ownPart(): readonly [from: number, to: number] {
    const compared = this.#store.compared.peek();
    if (!compared || !this.pair.peek()) return [0, 1];
    if (this.look.peek() === "difference" || this.look.peek() === "merge") return [1, 1];
    const samePoses = !compared.log && compared.trajectory === this.#store.trajectory.peek()?.name;
    return samePoses ? [0, 1] : [this.share, 1];
  }
}
