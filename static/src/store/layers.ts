/** The layers of a session by name, received while at least one component of the page is subscribed to them. */

import { batch, computed, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import type { LayerContent } from "../render/picture/overlays";
import type { BinaryFrame } from "../wire/decodeFrame";
import type { Command, Geometry, LayerInfo } from "../wire/protocol";
import { DisplayedMap } from "./displayedMap";

/** The map of a session: its first layer, which is sent by default. */
export const MAP = "map";
/** The other map of a session that compares two. */
export const SECOND_MAP = "second_map";

/** The value of a map for a name, created if it is missing. */
function entryOf<T>(map: Map<string, T>, name: string, make: () => T): T {
  const known = map.get(name);
  if (known !== undefined) return known;
  const made = make();
  map.set(name, made);
  return made;
}

export class Layers {
  readonly #infos = signal<readonly LayerInfo[]>([]);
  /** The layers that the session has, in its order. */
  readonly infos: ReadonlySignal<readonly LayerInfo[]> = this.#infos;
  /** The contents of the layers other than grids, in the session's order. */
  readonly contents: ReadonlySignal<readonly LayerContent[]> = computed(() =>
    this.#infos.value
      .filter(({ kind }) => kind !== "grid")
      .map(({ name }) => this.#content(name).value)
      .filter((content) => content !== null),
  );
  readonly #grids = new Map<string, DisplayedMap>();
  readonly #contents = new Map<string, Signal<LayerContent | null>>();
  readonly #watchers = new Map<string, number>([[MAP, 1]]);
  readonly #send: (command: Command) => void;

  /** `send` sends a command to the server; it may do nothing while there is no connection. */
  constructor(send: (command: Command) => void) {
    this.#send = send;
  }

  /** The grid of a layer, whether or not the session currently has it. */
  grid(name: string): DisplayedMap {
    return entryOf(this.#grids, name, () => new DisplayedMap());
  }

  /** The points, path or graph of a layer; null if there are none. */
  content(name: string): ReadonlySignal<LayerContent | null> {
    return this.#content(name);
  }

  #content(name: string): Signal<LayerContent | null> {
    return entryOf(this.#contents, name, () => signal(null));
  }

  /** Subscribe to a layer, which may not exist yet. The result unsubscribes; the last one clears the layer. */
  subscribe(name: string): () => void {
    const count = this.#watchers.get(name) ?? 0;
    this.#watchers.set(name, count + 1);
    if (count === 0) this.#sendSubscription();
    let isOver = false;
    return () => {
      if (isOver) return;
      isOver = true;
      const left = (this.#watchers.get(name) ?? 1) - 1;
      this.#watchers.set(name, left);
      if (left > 0) return;
      this.#watchers.delete(name);
      this.#drop(name);
      this.#sendSubscription();
    };
  }

  #sendSubscription(): void {
    this.#send({ type: "subscribe", layers: [...this.#watchers.keys()] });
  }

  /** The first commands of a new connection: the tiles to resume from, and the subscriptions. */
  opening(epochId: string | undefined): readonly Command[] {
    const commands: Command[] = [];
    for (const [name, grid] of this.#grids) {
      const { complete } = grid;
      if (complete && epochId !== undefined)
        commands.push({ type: "resume", epoch_id: epochId, layer: name, ...complete });
    }
    const wanted = [...this.#watchers.keys()];
    if (wanted.length !== 1 || wanted[0] !== MAP) commands.push({ type: "subscribe", layers: wanted });
    return commands;
  }

  // -- received from the stream ------------------------------------------------------------------------------------

  setLayers(infos: readonly LayerInfo[]): void {
    const before = this.#infos.peek();
    batch(() => {
      this.#infos.value = infos;
      // A layer that was removed or created again is cleared. A grid is kept until its successor is complete.
      for (const { name, id, kind } of before)
        if (kind !== "grid" && !infos.some((info) => info.id === id)) this.#content(name).value = null;
    });
  }

  begin(geometry: Geometry): void {
    const info = this.#infos.peek().find(({ id }) => id === geometry.layer);
    if (info) this.grid(info.name).begin(geometry, info.style);
  }

  take(frame: BinaryFrame): void {
    const info = this.#infos.peek().find(({ id }) => id === frame.layer);
    if (!info || !this.#watchers.has(info.name)) return; // removed, or no longer subscribed
    if (frame.kind === "tiles" || frame.kind === "changes") this.grid(info.name).takeTiles(frame);
    else if (info.kind !== "grid") {
      const { columns, kind, style } = info;
      const { edges = null, values = null } = frame.kind === "graph" ? frame : {};
      this.#content(info.name).value = { kind, style, names: columns, columns: frame.columns, edges, values };
    }
  }

  #drop(name: string): void {
    batch(() => {
      this.#grids.get(name)?.clear();
      const content = this.#contents.get(name);
      if (content) content.value = null;
    });
  }

  /** Discard what was received. The displayed maps are kept until newer ones are complete. */
  forget(): void {
    for (const grid of this.#grids.values()) grid.forget();
  }
}
