/** Zoomed-in stepping: the view follows the current cell. */

import { type Cell, centreOf } from "../../grid/lattice";
import type { Size, View } from "../../render/view";
import type { Geometry } from "../../wire/protocol";

/** Width of a cell in the zoomed-in view, pixels. */
const CELL_PX = 16;
/** The view does not move while the cell is in this central fraction of the picture. */
const CENTRAL = 0.7;

/** Metres per pixel of the zoomed-in view. */
export const zoomedInScale = (geometry: Geometry): number => geometry.resolution / CELL_PX;

/** A view that contains a cell: the present one if the cell is well inside, else centred on the cell. */
export function viewWithCell(view: View, size: Size, geometry: Geometry, cell: Cell): View {
  const [x, y] = centreOf(geometry, cell);
  const reach = (CENTRAL / 2) * view.scale;
  const isInSight = Math.abs(x - view.x) <= reach * size.width && Math.abs(y - view.y) <= reach * size.height;
  return isInSight ? view : { ...view, x, y };
}
