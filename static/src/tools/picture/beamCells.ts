import { along, type Beam } from "../../grid/beams";
import { type Cell, cellAt, centreOf, fromLattice } from "../../grid/lattice";
import {
  effectiveReading,
  halfWindow,
  INITIAL_PARAMETERS,
  increment,
  isNoReturn,
  type SensorModelParameters,
} from "../../grid/sensorModel";
import { cellsAlong } from "../../grid/textbook";
import type { Brush } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Geometry, Pose, Values } from "../../wire/protocol";

/** Cells narrower than this are not outlined one by one. */
const LEAST_PX = 3;

/** A cell on a beam and the evidence of the beam for it: occupied, free, or none if no return is ignored. */
export interface Crossed {
  readonly cell: Cell;
  readonly evidence: "hit" | "miss" | "prior";
}

/**
 * The cells on a beam and its evidence for them, as in `evidence_along_beam` in mapper/mapping/textbook.py; for a cone
 * the cells on its axis. `rangeMax` is the max range of sensor and map; `values` are the map's parameters.
 */
export function crossed(geometry: Geometry, from: Pose, beam: Beam, rangeMax: number, values: Values): Crossed[] {
  const parameters: SensorModelParameters = {
    ...INITIAL_PARAMETERS,
    ...(values as Partial<SensorModelParameters>),
    resolution: geometry.resolution,
    range_max: rangeMax,
  };
  const traversal = values.traversal === "amanatides_woo" ? values.traversal : "bresenham";
  const z = effectiveReading(beam.range ?? Number.POSITIVE_INFINITY, parameters);
  if (isNoReturn(z, parameters)) {
    const evidence = parameters.no_return === "free" ? "miss" : "prior";
    return cellsAlong(geometry, from, beam.bearing, rangeMax, { traversal }).map((cell) => ({ cell, evidence }));
  }
  const half = halfWindow(z, parameters);
  const end = cellAt(geometry, ...along(from, beam.bearing, z));
  const cells: Crossed[] = [];
  let isEndFound = false;
  for (const cell of cellsAlong(geometry, from, beam.bearing, z + half, { traversal })) {
    const [x, y] = centreOf(geometry, cell);
    const s = Math.hypot(x - from[0], y - from[1]);
    const isEnd = cell.row === end.row && cell.col === end.col;
    if (isEnd) cells.push({ cell, evidence: "hit" });
    else if (half === 0 || s < z - half) cells.push({ cell, evidence: "miss" });
    else if (s <= z + half) cells.push({ cell, evidence: increment(s, z, parameters) > 0 ? "hit" : "miss" });
    isEndFound ||= isEnd;
  }
  return isEndFound ? cells : [...cells, { cell: end, evidence: "hit" }];
}

/** Outline cells in the colours of their evidence. */
export function paintBeamCells(
  { ctx, view, size, colours }: Brush,
  geometry: Geometry,
  cells: readonly Crossed[],
): void {
  if (geometry.resolution / view.scale < LEAST_PX) return;
  ctx.lineWidth = 1;
  for (const part of ["prior", "miss", "hit"] as const) {
    ctx.beginPath();
    for (const { cell, evidence } of cells) {
      if (evidence !== part) continue;
      const { row, col } = cell;
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
    ctx.strokeStyle = colours[part];
    ctx.stroke();
  }
}
