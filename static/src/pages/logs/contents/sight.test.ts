import { expect, test } from "vitest";
import { sightOf } from "./sight";

// A camera 1 m above the origin that looks along x, its image 1 wide for a width of 1 at 1 m, and as high:
// x to the right is −y of the map, y down is −z; u = 0.5 − y / x, v = 0.5 + (1 − z) / x, w = x.
const AHEAD = [0.5, -1, 0, 0, 0.5, 0, -1, 1, 1, 0, 0, 0];

test.each([
  [[4, 1], { where: "inside", u: 0.25, v: 0.75 }],
  [[2, -1], { where: "inside", u: 1, v: 1 }],
  [[4, -3], { where: "outside", u: 1.25, v: 0.75 }],
  [[1, 0], { where: "outside", u: 0.5, v: 1.5 }],
  [[-4, 1], { where: "behind", u: 0, v: 0 }],
  [[0, 0], { where: "behind", u: 0, v: 0 }],
] as const)("the place %j on the floor is seen where a pinhole has it", (place, sight) => {
  expect(sightOf(AHEAD, [...place])).toEqual(sight);
});
