import type { Beam } from "../../beams";
import { type Cell, fromLattice } from "../../lattice";
import type { Geometry } from "../../protocol";
import { toScreen } from "../../view";
import type { Brush } from "./brush";

/** Cells narrower than this are not outlined one by one. */
const LEAST_PX = 3;

/** The cells that a beam crosses, in the colours of the evidence they get: the last holds the reading. */
export function paintBeamCells(
  { ctx, view, size, inks }: Brush,
  geometry: Geometry,
  cells: readonly Cell[],
  beam: Beam,
  rangeMax: number,
): void {
  if (geometry.resolution / view.scale < LEAST_PX) return;
  const isHit = beam.range !== null && beam.range <= rangeMax;
  ctx.lineWidth = 1;
  for (const part of ["miss", "hit"] as const) {
    const own = part === "hit" ? cells.slice(isHit ? -1 : cells.length) : cells.slice(0, isHit ? -1 : undefined);
    ctx.beginPath();
    for (const { row, col } of own) {
      const corners = [
        [col, row],
        [col + 1, row],
        [col + 1, row + 1],
        [col, row + 1],
      ] as const;
      for (const [i, [u, v]] of corners.entries()) {
        const [x, y] = toScreen(view, size, ...fromLattice(geometry, u, v));
        if (i === 0) ctx.moveTo(x, y);
        else ctx.lineTo(x, y);
      }
      ctx.closePath();
    }
    ctx.strokeStyle = inks[part];
    ctx.stroke();
  }
}
