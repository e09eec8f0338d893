/** Images of a field over the figure: RGBA, top row first. */

import type { GridGeometry } from "../../grid/occupancyGrid";
import { type Rgb, tokenRgb } from "../../style/colour";
import { isDark } from "../../ui/browser/theme";
import { ELSEWHERE, STARTS, TRUE_POSE } from "./matching";
import { GEOMETRY } from "./world";

type Image = Uint8ClampedArray<ArrayBuffer>;

function painted(
  { rows, cols }: GridGeometry,
  colourOf: (index: number) => readonly [...rgb: Rgb, alpha: number],
): Image {
  void isDark.value; // another theme, other colours
  const image = new Uint8ClampedArray(4 * rows * cols);
  for (let row = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) image.set(colourOf(row * cols + col), 4 * ((rows - 1 - row) * cols + col));
  return image;
}

/** Scores 0 to 1: the shape relative to the highest one, and the paler the lower that is. */
export function paintHill(scores: Float32Array): Image {
  const rgb = tokenRgb("--beam-fill");
  const highest = Math.max(1e-6, ...scores);
  const strength = 255 * (0.35 + 0.65 * highest);
  return painted(GEOMETRY, (index) => [...rgb, strength * ((scores[index] ?? 0) / highest) ** 2]);
}

/** Starts by how the match ends; those not computed yet in the colour of the page. */
export function paintBasin(ends: Uint8Array): Image {
  const [found, elsewhere] = [tokenRgb("--miss-fill"), tokenRgb("--hit-wash")];
  const pending = tokenRgb("--surface");
  return painted(STARTS, (index) => {
    if (ends[index] === TRUE_POSE) return [...found, 255];
    return ends[index] === ELSEWHERE ? [...elsewhere, 255] : [...pending, 255];
  });
}
