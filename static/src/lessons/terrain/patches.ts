/** Patches to begin with: heights of nine points of a square of two metres. */

import type { Place } from "./model";

/** Where the points are, m: nearly a lattice. */
const PLACES: readonly (readonly [x: number, y: number])[] = [
  [-0.82, -0.74],
  [0.05, -0.8],
  [0.78, -0.7],
  [-0.72, 0.06],
  [0.02, -0.04],
  [0.84, 0.05],
  [-0.78, 0.76],
  [-0.02, 0.82],
  [0.8, 0.72],
];
const NOISE = [0.01, -0.012, 0.006, -0.008, 0.012, -0.005, 0.004, 0.01, -0.014];

const patch = (height: (x: number, y: number) => number): readonly Place[] =>
  PLACES.map(([x, y], k) => [x, y, height(x, y) + (NOISE[k] as number)]);

interface Preset {
  readonly id: string;
  readonly label: string;
  readonly points: readonly Place[];
}

export const PRESETS: readonly Preset[] = [
  { id: "floor", label: "Floor", points: patch(() => 0.1) },
  { id: "ramp", label: "Ramp", points: patch((x) => 0.3 + 0.28 * x) },
  { id: "stone", label: "Stone", points: patch((x, y) => (Math.hypot(x, y) < 0.2 ? 0.55 : 0.1)) },
  { id: "step", label: "Step", points: patch((x) => (x > 0.4 ? 0.4 : 0.1)) },
];
