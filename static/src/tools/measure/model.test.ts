import { expect, test } from "vitest";
import { Cells } from "../../render/map/cells";
import type { MapPicture } from "../../render/map/mapPicture";
import { TILE } from "../../wire/protocol";
import { angleAt, areaOf, headingOf, lengthOf, measuredText, scaleBar, scaleText, snapped } from "./model";

const SQUARE = [
  [0, 0],
  [2, 0],
  [2, 2],
  [0, 2],
] as const;

test("lengths, areas and angles", () => {
  expect(lengthOf(SQUARE)).toBe(6);
  expect(lengthOf(SQUARE, true)).toBe(8);
  expect(areaOf(SQUARE)).toBe(4);
  expect(areaOf([...SQUARE].reverse())).toBe(4);
  expect(headingOf([1, 1], [1, 3])).toBe(90);
  expect(angleAt([0, 0], [2, 0], [2, 2])).toBe(90);
});

test("what is measured says how exact it is", () => {
  expect(measuredText("distance", [[0, 0]], 0.05)).toContain("two sides of a door");
  expect(
    measuredText(
      "distance",
      [
        [0, 0],
        [0.9, 0],
      ],
      0.05,
    ),
  ).toBe("0.90 m ± 0.05 m, direction 0.0°");
  expect(measuredText("distance", SQUARE.slice(0, 3), 0.05)).toBe("2.00 m ± 0.05 m, angle 90.0°, together 4.00 m");
  expect(measuredText("area", SQUARE, 0.05)).toBe("4.00 m², around it 8.00 m ± 0.05 m");
});

test("in 3D lengths, areas and angles are those in space", () => {
  expect(
    lengthOf([
      [0, 0, 0],
      [1, 2, 2],
      [1, 2, 0],
    ]),
  ).toBe(5);
  // A roof of 3 m by the hypotenuse of 4 m and 3 m.
  const roof = [
    [0, 0, 0],
    [3, 0, 0],
    [3, 4, 3],
    [0, 4, 3],
  ] as const;
  expect(areaOf(roof)).toBe(15);
  expect(areaOf([...roof].reverse())).toBe(15);
  expect(angleAt([0, 0, 1], [0, 0, 0], [2, 0, 0])).toBe(90);
  expect(angleAt([1, 1, 0], [0, 0, 0], [1, 1, Math.SQRT2])).toBeCloseTo(45, 9);
});

test("in 3D the height difference is stated, and no error of measured points", () => {
  const step = [
    [0, 0, 0.1],
    [0, 2, 1.6],
  ] as const;
  expect(measuredText("distance", step, 0)).toBe("2.50 m, height difference 1.50 m, direction 90.0°");
  expect(measuredText("distance", [...step].reverse(), 0.05)).toBe(
    "2.50 m ± 0.05 m, height difference −1.50 m, direction −90.0°",
  );
  expect(
    measuredText(
      "area",
      [
        [0, 0, 0],
        [0, 2, 0],
        [0, 2, 3],
      ],
      0.1,
    ),
  ).toContain("3.00 m², around it 8.61 m ± 0.10 m");
});

/** A wall of cells of 0.1 m along y from which the columns 10 to 18 are left out: a door of 0.9 m. */
function wall(): MapPicture {
  const cells = new Cells();
  const tile = new Int8Array(TILE * TILE).fill(-100);
  for (let col = 0; col < TILE; col++) if (col < 10 || col > 18) tile[20 * TILE + col] = 120;
  cells.setTile(0, 0, new Uint8Array(tile.buffer));
  const geometry = { resolution: 0.1, rows: TILE, cols: TILE, origin: [0, 0, 0], low: -3, high: 3 };
  return { cells, style: "belief", geometry: geometry as unknown as MapPicture["geometry"] };
}

test("the sides of a door snap to the borders of its cells", () => {
  const map = wall();
  const left = snapped(map, [1.04, 2.06], 0.3);
  const right = snapped(map, [1.83, 2.04], 0.3);
  expect(left?.[0]).toBeCloseTo(1.0, 9);
  expect(right?.[0]).toBeCloseTo(1.9, 9);
  expect((right?.[0] ?? 0) - (left?.[0] ?? 0)).toBeCloseTo(0.9, 9);
  expect(snapped(map, [1.45, 0.5], 0.3)).toBeNull();
});

test("in a recorded costmap points snap to what is lethal, not to what is near it", () => {
  const cells = new Cells();
  const costs = Array.from({ length: TILE * TILE }, (_, k) => [0, 100, 253, 254, 253][Math.min(4, k % TILE)] ?? 0);
  const sent = Uint8Array.from(costs, (cost) => (cost + 1) ^ 0x80);
  cells.setTile(0, 0, sent);
  const geometry = { resolution: 0.1, rows: TILE, cols: TILE, origin: [0, 0, 0], low: 0, high: 254 };
  const map = { cells, style: "recorded_costs", geometry: geometry as unknown as MapPicture["geometry"] };
  expect(snapped(map, [0.23, 1.05], 0.2)?.[0]).toBeCloseTo(0.3, 9);
  expect(snapped(map, [0.44, 1.05], 0.2)?.[0]).toBeCloseTo(0.4, 9);
});

test("the bar of the scale is a round length that fits", () => {
  expect([0.01, 0.02, 0.05, 0.0011].map((scale) => scaleBar(scale, 120))).toEqual([1, 2, 5, 0.1]);
  expect([1000, 2, 0.5, 0.05].map(scaleText)).toEqual(["1 km", "2 m", "50 cm", "5 cm"]);
});
