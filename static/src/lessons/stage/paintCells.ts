import type { GridGeometry } from "../../grid/occupancyGrid";
import type { Projection } from "./camera";

/** Paint cells in RGBA, row 0 at the smallest y, over the map. */
export function paintCells(
  context: CanvasRenderingContext2D,
  at: Projection,
  { rows, cols, resolution }: GridGeometry,
  colours: Uint8ClampedArray,
): void {
  const flipped = new Uint8ClampedArray(colours.length);
  const stride = 4 * cols;
  for (let row = 0; row < rows; row++)
    flipped.set(colours.subarray(row * stride, (row + 1) * stride), (rows - 1 - row) * stride);
  const picture = new OffscreenCanvas(cols, rows);
  picture.getContext("2d")?.putImageData(new ImageData(flipped, cols, rows), 0, 0);
  const side = resolution * at.metre;
  context.drawImage(picture, at.x(0), at.y(rows * resolution), cols * side, rows * side);
}
