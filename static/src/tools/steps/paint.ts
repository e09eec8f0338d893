/** Painting of a scan that is added to the map cell by cell: the updated cells, the current beam and cell. */

import { beamAt } from "../../grid/beams";
import { byteAt } from "../../grid/cellValues";
import { fromLattice } from "../../grid/lattice";
import { mapColours, palette } from "../../render/map/palettes";
import { type Brush, paintBeam, paintCell } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import { paintBeamCells } from "../picture/beamCells";
import { valuesNow } from "./stepping";

/** Paint the current beam and its cells; with `onMap` also the updated cells in the map's colours. */
export function paintSteps(store: Store, brush: Brush, onMap: boolean): void {
  const stepping = store.stepping.peek();
  if (!stepping) return;
  const { geometry, frame, pose, steps, done } = stepping;
  const { ctx, view, size, colours } = brush;
  if (onMap) {
    const mapPalette = palette(geometry, mapColours());
    const px = geometry.resolution / view.scale;
    for (const [name, logOdds] of valuesNow(store, stepping)) {
      const [row, col] = name.split(" ").map(Number) as [number, number];
      const byte = Math.round(Math.min(255, Math.max(1, byteAt(logOdds, geometry))));
      const [x, y] = toScreen(view, size, ...fromLattice(geometry, col, row + 1));
      ctx.fillStyle = `rgb(${mapPalette[4 * byte]} ${mapPalette[4 * byte + 1]} ${mapPalette[4 * byte + 2]})`;
      ctx.fillRect(x, y, px + 0.5, px + 0.5);
    }
  }
  const now = steps[Math.max(0, done - 1)];
  const beam = now && beamAt(frame, now.beam);
  if (!now || !beam) return;
  const cells = steps
    .filter((step) => step.beam === now.beam)
    .map(({ cell, isHit }) => ({ cell, evidence: isHit ? ("hit" as const) : ("miss" as const) }));
  paintBeam(brush, pose, beam, frame.range_max);
  paintBeamCells(brush, geometry, cells);
  if (done > 0) paintCell(brush, geometry, now.cell.row, now.cell.col, now.isHit ? colours.hit : colours.miss);
}
