/** The outline of the robot as a polygon that must not cross itself, as in mapper/costmap/footprint.py. */

import type { Point } from "../../wire/protocol";

/** Initial outlines, m. */
export const OUTLINES: readonly { readonly label: string; readonly corners: readonly Point[] }[] = [
  { label: "Hexagon", corners: hexagon(0.231) },
  { label: "Rectangle", corners: rectangle(0.35, 0.22) },
  { label: "Wide", corners: rectangle(0.3, 0.5) },
];

function hexagon(radius: number): readonly Point[] {
  return Array.from({ length: 6 }, (_, i) => {
    const angle = (i * Math.PI) / 3;
    return [rounded(radius * Math.cos(angle)), rounded(radius * Math.sin(angle))] as const;
  });
}

function rectangle(x: number, y: number): readonly Point[] {
  return [
    [x, y],
    [-x, y],
    [-x, -y],
    [x, -y],
  ];
}

/** Round to whole millimetres. */
export function rounded(value: number): number {
  return Math.round(value * 1000) / 1000;
}

const turn = (a: Point, b: Point, c: Point): number => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

const isBetween = (a: Point, b: Point, c: Point): boolean =>
  Math.min(a[0], b[0]) <= c[0] &&
  c[0] <= Math.max(a[0], b[0]) &&
  Math.min(a[1], b[1]) <= c[1] &&
  c[1] <= Math.max(a[1], b[1]);

/** Whether the segments a b and c d have a point in common. */
function meet(a: Point, b: Point, c: Point, d: Point): boolean {
  const turns = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)] as const;
  if (turns[0] * turns[1] < 0 && turns[2] * turns[3] < 0) return true;
  const ends = [
    [a, b, c],
    [a, b, d],
    [c, d, a],
    [c, d, b],
  ] as const;
  return ends.some(([p, q, r], i) => turns[i] === 0 && isBetween(p, q, r));
}

/** A sentence if the outline of a robot crosses itself, which Nav2 accepts; null otherwise. */
export function crossingOf(corners: readonly Point[]): string | null {
  const n = corners.length;
  const at = (i: number): Point => corners[i % n] as Point;
  for (let i = 0; i < n; i++)
    for (let j = i + 2; j < n; j++)
      if ((j + 1) % n !== i && meet(at(i), at(i + 1), at(j), at(j + 1)))
        return (
          `The outline crosses itself: the edges from corner ${i + 1} and from corner ${j + 1} meet. As in Nav2 it ` +
          "is taken as it is, and the inscribed radius is the distance from the centre to the nearest edge."
        );
  return null;
}
