/** A map as it comes over the wire: the picture on show, and the one of a new epoch that replaces it when complete. */

import { batch, type ReadonlySignal, signal } from "@preact/signals";
import { decompress } from "fzstd";
import { byteAt } from "../grid/cellValues";
import { Cells } from "../render/map/cells";
import type { MapPicture } from "../render/map/mapPicture";
import type { TilesFrame } from "../wire/decodeFrame";
import { type Geometry, ProtocolError } from "../wire/protocol";

/** Told of a cell that is observed for the first time or changes its mind, and of the instant (performance.now). */
export type OnBloom = (row: number, col: number, now: number) => void;

/** A new epoch replaces the picture when it is complete; but the old picture stays no longer than this. */
const STALE_PICTURE_MS = 250;

export class DisplayedMap {
  readonly #map = signal<MapPicture | null>(null);
  readonly #version = signal(0);
  /** The map on show. */
  readonly map: ReadonlySignal<MapPicture | null> = this.#map;
  /** Grows whenever cells of the map on show change. */
  readonly version: ReadonlySignal<number> = this.#version;
  /** Hears of cells that are seen for the first time or change their mind, while the map on show changes. */
  onBloom: OnBloom | null = null;
  #isRemade = false;
  #coming: (MapPicture & { readonly since: number }) | null = null;
  #newest = 0;
  #complete: { readonly epoch: number; readonly revision: number } | null = null;

  /** What has been received in full, for a later connection to go on from; null for nothing. */
  get complete(): { readonly epoch: number; readonly revision: number } | null {
    return this.#complete;
  }

  /** A grid of this geometry is to come, painted in the palette of this style. */
  begin(geometry: Geometry, style: string): void {
    const newest = this.#coming ?? this.#map.peek();
    if (newest?.geometry.epoch === geometry.epoch) return;
    this.#coming = { geometry, style, cells: new Cells(), since: this.#coming?.since ?? performance.now() };
    this.#complete = null;
    if (!this.#map.peek()) this.#show();
  }

  /** What comes next is the same readings taken otherwise: nothing of it was just seen. */
  remake(): void {
    this.#isRemade = true;
  }

  takeTiles(frame: TilesFrame): void {
    const coming = this.#coming;
    const picture = coming ?? this.#map.peek();
    if (!picture || picture.geometry.epoch !== frame.epoch) return; // of an older epoch: void
    const undecided = byteAt(0, picture.geometry);
    const hear = coming || !this.#complete || this.#isRemade ? null : this.onBloom;
    const now = performance.now();
    const bloom = hear ? (row: number, col: number): void => hear(row, col, now) : undefined;
    for (const tile of frame.tiles) {
      let values: Uint8Array;
      try {
        // Into memory of its own: given some, fzstd makes a tiny array whose buffer costs a browser more than the tile.
        values = decompress(tile.data);
        picture.cells.setTile(tile.tx, tile.ty, values, undecided, bloom);
      } catch (error) {
        throw new ProtocolError("tile.data", `Tile (${tile.tx}, ${tile.ty}) cannot be read: ${String(error)}`);
      }
      this.#newest = Math.max(this.#newest, tile.revision);
    }
    batch(() => {
      if (coming && (frame.complete || performance.now() - coming.since > STALE_PICTURE_MS)) this.#show();
      if (frame.tiles.length > 0) this.#version.value++;
    });
    if (frame.complete && frame.tiles.length > 0) this.#isRemade = false;
    if (frame.complete) this.#complete = { epoch: frame.epoch, revision: this.#newest };
  }

  #show(): void {
    const coming = this.#coming;
    if (!coming) return;
    this.#coming = null;
    this.#map.value = { geometry: coming.geometry, style: coming.style, cells: coming.cells };
    this.#version.value++;
  }

  forget(): void {
    this.#complete = null;
    this.#newest = 0;
    this.#coming = null;
    const map = this.#map.peek();
    // Keep showing what there was, under an epoch that no server will name, until something newer is complete.
    if (map) this.#map.value = { ...map, geometry: { ...map.geometry, epoch: -1 } };
  }

  /** Show nothing. */
  clear(): void {
    this.forget();
    if (this.#map.peek()) this.#version.value++;
    this.#map.value = null;
  }
}
