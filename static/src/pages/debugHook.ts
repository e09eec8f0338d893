/**
 * `window.gridbloom`: the state of the page for tests and for the browser's console. The pages do not use it.
 */

import { logOddsAt, stateAt, thresholds } from "../grid/cellValues";
import { type Picture, paintStats } from "../render/picture/Picture";
import { toScreen } from "../render/view";
import type { Connection } from "../store/connect";
import type { Point } from "../wire/protocol";

interface CellInfo {
  readonly row: number;
  readonly col: number;
  readonly byte: number;
  readonly log_odds: number | null;
  readonly state: string;
}

interface Hook {
  readonly connection: Connection;
  /** Of the point clouds on the stage of a log. */
  clouds?: Connection;
  /** Counts of observed cells of the displayed map by state. */
  cells(): { readonly free: number; readonly undecided: number; readonly occupied: number };
  /** The map's value at a world point; null outside the grid. */
  readState(xy: Point): CellInfo | null;
  /** The CSS pixel of a world point, from the picture's upper left corner. */
  screen(xy: Point): Point | null;
  /** The colour on the map's canvas at a world point, freshly painted; null outside the picture. */
  colourAt(xy: Point): readonly number[] | null;
  /** Totals since the page opened: bytes and frames received, paints and their milliseconds. */
  stats(): Record<string, number>;
}

declare global {
  interface Window {
    gridbloom?: Hook;
  }
}

export function exposeClouds(clouds: Connection): void {
  if (window.gridbloom) window.gridbloom.clouds = clouds;
}

export function exposeHook(connection: Connection, picture: () => Picture | null): void {
  const { store, stream } = connection;
  const screen = (xy: Point): Point | null => {
    const view = store.view.peek();
    const size = picture()?.size;
    return view && size ? toScreen(view, size, xy[0], xy[1]) : null;
  };
  window.gridbloom = {
    connection,
    screen,
    cells: () => {
      const map = store.map.peek();
      if (!map) return { free: 0, undecided: 0, occupied: 0 };
      const { below, above } = thresholds(map.geometry);
      return map.cells.count(below, above);
    },
    readState: (xy) => {
      const map = store.map.peek();
      const cell = store.cellOf(xy);
      if (!map || !cell) return null;
      const byte = map.cells.at(cell.row, cell.col);
      const log_odds = byte === 0 ? null : logOddsAt(byte, map.geometry);
      return { ...cell, byte, log_odds, state: stateAt(byte, map.geometry) };
    },
    colourAt: (xy) => {
      const at = screen(xy);
      const shown = picture();
      return at && shown ? shown.readPixel(at[0], at[1]) : null;
    },
    stats: () => ({ ...stream.traffic, ...paintStats }),
  };
}
