/** A step seen closely: the view follows the cell of the moment, as a text follows its cursor. */

import { type Cell, centreOf } from "../../lattice";
import type { Geometry } from "../../protocol";
import type { Size, View } from "../../view";

/** How wide a cell is then, in pixels, unless a person zooms. */
const CELL_PX = 16;
/** The view stays while the cell is in this part of the picture, around its middle. */
const CALM = 0.7;

/** Metres to a pixel from near by. */
export const closeScale = (geometry: Geometry): number => geometry.resolution / CELL_PX;

/** The view with a cell in it: the one that there is, where the cell is well in sight in it. */
export function following(view: View, size: Size, geometry: Geometry, cell: Cell): View {
  const [x, y] = centreOf(geometry, cell);
  const reach = (CALM / 2) * view.scale;
  const isInSight = Math.abs(x - view.x) <= reach * size.width && Math.abs(y - view.y) <= reach * size.height;
  return isInSight ? view : { ...view, x, y };
}
