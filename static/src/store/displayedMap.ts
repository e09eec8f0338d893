/** A map as received over the wire: the displayed picture, and that of a new epoch, which replaces it when complete. */

import { batch, type ReadonlySignal, signal } from "@preact/signals";
import { decompress } from "fzstd";
import { byteAt } from "../grid/cellValues";
import { Cells } from "../render/map/cells";
import type { MapPicture } from "../render/map/mapPicture";
import type { ChangesFrame, TilesFrame } from "../wire/decodeFrame";
import { type Geometry, ProtocolError } from "../wire/protocol";

/** Called for a cell that is observed for the first time or crosses log-odds 0; `now` is performance.now(). */
export type OnCellChange = (row: number, col: number, now: number) => void;

/** A new epoch replaces the picture when it is complete, at the latest after this time. */
const STALE_PICTURE_MS = 250;

export class DisplayedMap {
  readonly #map = signal<MapPicture | null>(null);
  readonly #version = signal(0);
  /** The displayed map. */
  readonly map: ReadonlySignal<MapPicture | null> = this.#map;
  /** Incremented whenever cells of the displayed map change. */
  readonly version: ReadonlySignal<number> = this.#version;
  /** Called for changed cells, but not for those of a complete new picture. */
  onCellChange: OnCellChange | null = null;
  #isRemade = false;
  #coming: (MapPicture & { readonly since: number }) | null = null;
  #newest = 0;
  #complete: { readonly epoch: number; readonly revision: number } | null = null;

  /** The last epoch and revision that were received completely, for the next connection to resume; null for none. */
  get complete(): { readonly epoch: number; readonly revision: number } | null {
    return this.#complete;
  }

  /** Prepare for the tiles of a grid with this geometry, painted in the palette of this style. */
  begin(geometry: Geometry, style: string): void {
    const newest = this.#coming ?? this.#map.peek();
    if (newest?.geometry.epoch === geometry.epoch) return;
    this.#coming = { geometry, style, cells: new Cells(), since: this.#coming?.since ?? performance.now() };
    this.#complete = null;
    if (!this.#map.peek()) this.#show();
  }

  /** The next tiles are a recomputation from the same readings: their cells are not reported as changed. */
  remake(): void {
    this.#isRemade = true;
  }

  takeTiles(frame: TilesFrame | ChangesFrame): void {
    const coming = this.#coming;
    const picture = coming ?? this.#map.peek();
    if (!picture || picture.geometry.epoch !== frame.epoch) return; // of an older epoch
    const undecided = byteAt(0, picture.geometry);
    const listener = coming || !this.#complete || this.#isRemade ? null : this.onCellChange;
    const now = performance.now();
    const onChange = listener ? (row: number, col: number): void => listener(row, col, now) : undefined;
    if (frame.kind === "changes") {
      for (const { tx, ty, places, values } of frame.tiles)
        picture.cells.setCells(tx, ty, places, values, undecided, onChange);
      this.#newest = Math.max(this.#newest, frame.revision);
    } else {
      for (const tile of frame.tiles) {
        try {
          // Without an output buffer; with one, fzstd allocates a tiny array whose buffer costs more than the tile.
          picture.cells.setTile(tile.tx, tile.ty, decompress(tile.data), undecided, onChange);
        } catch (error) {
          throw new ProtocolError("tile.data", `Tile (${tile.tx}, ${tile.ty}) cannot be read: ${String(error)}`);
        }
        this.#newest = Math.max(this.#newest, tile.revision);
      }
    }
    if (frame.complete) this.#complete = { epoch: frame.epoch, revision: this.#newest };
    batch(() => {
      if (coming && (frame.complete || performance.now() - coming.since > STALE_PICTURE_MS)) this.#show();
      if (frame.tiles.length > 0) this.#version.value++;
    });
    if (frame.complete && frame.tiles.length > 0) this.#isRemade = false;
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
    // Keep the old picture, with an epoch that no server uses, until a newer one is complete.
    if (map) this.#map.value = { ...map, geometry: { ...map.geometry, epoch: -1 } };
  }

  /** Show nothing. */
  clear(): void {
    this.forget();
    if (this.#map.peek()) this.#version.value++;
    this.#map.value = null;
  }
}
