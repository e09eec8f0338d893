import { expect, test } from "vitest";
import { distancesOf, type Fusion, MOVE, occupancyOf, occupiedOf, RESOLUTION, readingsOf, zeroCrossing } from "./model";
import vectors from "./tsdf.vectors.json";

const FUSION: Fusion = { truncation: 0.4, maxWeight: 64, isCarved: false, hasDropOff: false };
const mean = (values: readonly number[]): number => values.reduce((sum, value) => sum + value, 0) / values.length;

test("log-odds, distances and weights are those of the library", () => {
  expect(vectors.length).toBeGreaterThan(4);
  for (const { readings, fusion, logOdds, distances, weights } of vectors) {
    const cells = occupancyOf(readings);
    const voxels = distancesOf(readings, fusion);
    logOdds.forEach((value, k) => {
      if (value === null) expect(cells[k]).toBeNull();
      else expect(cells[k]).toBeCloseTo(value, 4);
    });
    weights.forEach((weight, k) => {
      expect(voxels[k]?.weight).toBeCloseTo(weight, 4);
      if (weight > 0) expect(voxels[k]?.distance).toBeCloseTo(distances[k] as number, 4);
    });
  }
});

test("without noise the zero crossing is the wall, wherever in its cell that is", () => {
  for (const wall of [1.201, 1.23, 1.25, 1.279, 1.3]) {
    const crossing = zeroCrossing(distancesOf([wall], FUSION));
    expect(crossing?.at).toBeCloseTo(wall, 9);
    expect(crossing?.slope).toBeCloseTo(-1, 9);
  }
});

test("with noise the zero crossing is the mean of the readings, and occupancy has a whole cell", () => {
  const readings = readingsOf(1.25, 40, 0.015, false);
  expect(zeroCrossing(distancesOf(readings, FUSION))?.at).toBeCloseTo(mean(readings), 9);
  expect(occupiedOf(occupancyOf(readings))).toEqual([Math.floor(1.25 / RESOLUTION)]);
});

test("one reading that is too long leaves an occupied cell behind the wall", () => {
  expect(occupiedOf(occupancyOf([1.25, 1.25, 1.32, ...Array.from({ length: 30 }, () => 1.25)]))).toEqual([12, 13]);
});

test("after the wall was moved, a small maximum weight lets the surface follow and a large one does not", () => {
  const readings = readingsOf(1.23, 60, 0, true);
  const at = (maxWeight: number): number => zeroCrossing(distancesOf(readings, { ...FUSION, maxWeight }))?.at ?? 0;
  expect(at(64)).toBeCloseTo(1.23 + MOVE / 2, 9);
  expect(at(4)).toBeCloseTo(1.23 + MOVE, 2);
});

test("with a drop-off the weight falls from one voxel behind the reading to the truncation", () => {
  const weights = distancesOf([1.25], { ...FUSION, hasDropOff: true }).map(({ weight }) => weight);
  expect(weights.slice(9, 13)).toEqual([1, 1, 1, 1]);
  expect(weights[13]).toBeCloseTo(1, 9);
  expect(weights[14]).toBeCloseTo(2 / 3, 9);
  expect(weights[15]).toBeCloseTo(1 / 3, 9);
});

test("nothing is stored behind the truncation, and before it only free space that is wanted", () => {
  const stored = (isCarved: boolean): readonly number[] =>
    distancesOf([1.23], { ...FUSION, isCarved }).flatMap(({ weight }, k) => (weight > 0 ? [k] : []));
  expect(stored(false)).toEqual([8, 9, 10, 11, 12, 13, 14, 15]);
  expect(stored(true)).toEqual([...Array(16).keys()]);
});
