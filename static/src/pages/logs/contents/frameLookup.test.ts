import { expect, test } from "vitest";
import { poseInFrame } from "./frameLookup";

const edge = (parent: string, child: string, offset: number[] | null, angles: number[] | null = [0, 0, 0]) => ({
  parent,
  child,
  offset: offset as [number, number, number] | null,
  angles: angles as [number, number, number] | null,
  used: true,
});

/** x, y, z, roll, pitch, yaw to a millionth. */
const numbersOf = (pose: ReturnType<typeof poseInFrame>): readonly number[] =>
  "why" in pose ? [] : [...pose.offset, ...pose.angles].map((value) => Math.round(1e6 * value) / 1e6 + 0);

const QUARTER = Math.PI / 2;
const ROUNDED = 1.570796;
const TREE = [
  edge("map", "odom", [10, 0, 0], [0, 0, QUARTER]),
  edge("odom", "base", [2, 1, 0]),
  edge("base", "laser", [0.3, 0, 0.2], [QUARTER, 0, 0]),
  edge("base", "camera", [0.1, -0.2, 0.5], [0.2, -0.3, 0.4]),
];

test("the pose is composed along the tree, up, down and across", () => {
  expect(numbersOf(poseInFrame(TREE, "base", "map"))).toEqual([9, 2, 0, 0, 0, ROUNDED]);
  expect(numbersOf(poseInFrame(TREE, "map", "base"))).toEqual([-2, 9, 0, 0, 0, -ROUNDED]);
  expect(numbersOf(poseInFrame(TREE, "laser", "laser"))).toEqual([0, 0, 0, 0, 0, 0]);
  expect(numbersOf(poseInFrame(TREE, "base", "laser"))).toEqual([-0.3, -0.2, 0, -ROUNDED, 0, 0]);
});

test("there and back is where one was", () => {
  const there = poseInFrame(TREE, "camera", "laser");
  const back = poseInFrame(TREE, "laser", "camera");
  if (!("offset" in there) || !("offset" in back)) throw new Error("not found");
  const two = [
    edge("a", "b", [...there.offset], [...there.angles]),
    edge("b", "c", [...back.offset], [...back.angles]),
  ];
  expect(numbersOf(poseInFrame(two, "c", "a"))).toEqual([0, 0, 0, 0, 0, 0]);
});

test("a pose that is not known says why", () => {
  expect(poseInFrame([...TREE, edge("x", "y", [0, 0, 0])], "y", "map")).toEqual({
    why: "No transforms join y with map.",
  });
  const late = [edge("map", "odom", null, null), edge("odom", "base", [1, 0, 0])];
  expect(poseInFrame(late, "base", "map")).toEqual({
    why: "No transform of odom has been received yet at this moment.",
  });
  expect(numbersOf(poseInFrame(late, "base", "odom"))).toEqual([1, 0, 0, 0, 0, 0]);
});
