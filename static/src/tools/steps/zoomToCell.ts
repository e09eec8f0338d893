/** Zoomed-in stepping: the view follows the cell of the moment, as a text follows its cursor. */

import { type Cell, centreOf } from "../../grid/lattice";
import type { Size, View } from "../../render/view";
import type { Geometry } from "../../wire/protocol";

/** How wide a cell is then, in pixels, unless a person zooms. */
const CELL_PX = 16;
/** The view stays while the cell is in this part of the picture, around its middle. */
const CALM = 0.7;

/** Metres to a pixel from near by. */
export const zoomedInScale = (geometry: Geometry): number => geometry.resolution / CELL_PX;

/** The view with a cell in it: the one that there is, where the cell is well in sight in it. */
export function viewWithCell(view: View, size: Size, geometry: Geometry, cell: Cell): View {
  const [x, y] = centreOf(geometry, cell);
  const reach = (CALM / 2) * view.scale;
  const isInSight = Math.abs(x - view.x) <= reach * size.width && Math.abs(y - view.y) <= reach * size.height;
  return isInSight ? view : { ...view, x, y };
}
