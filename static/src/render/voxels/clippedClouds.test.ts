import { expect, test } from "vitest";
import { ClippedClouds, clipped, type NodeMessage } from "./clippedClouds";

const POINTS = new Float32Array([0, 0, 0, 1, 2, 3, -1, 0.5, 2]);
const COLORS = new Uint8Array([1, 2, 3, 4, 5, 6, 7, 8, 9]);
const cloud = (): NodeMessage => ({
  type: "PointCloudMessage",
  name: "/points/points",
  props: { points: POINTS, colors: COLORS },
});
const corner = (end: string, position: readonly number[]): NodeMessage => ({
  type: "SetPositionMessage",
  name: `/points/clip_${end}`,
  position,
});

test("points within the box are kept with their colours, its bounds included", () => {
  const kept = clipped({ points: POINTS, colors: COLORS }, [-1, 0, 0], [0.5, 2, 2]);
  expect([...kept.points]).toEqual([0, 0, 0, -1, 0.5, 2]);
  expect([...kept.colors]).toEqual([1, 2, 3, 7, 8, 9]);
  const first = new Uint8Array([1, 2, 3]);
  expect(clipped({ points: POINTS, colors: first }, [-1, 0, 0], [0.5, 2, 2]).colors).toBe(first);
});

test("a cloud is clipped when it comes, and again from all of its points when the box changes", () => {
  const clouds = new ClippedClouds();
  const first = [corner("low", [-9, -9, -9]), corner("high", [9, 9, 1]), cloud()];
  clouds.take(first);
  expect(first[2]?.props?.points).toEqual(new Float32Array([0, 0, 0]));
  expect(first).toHaveLength(3);
  const wider = [corner("high", [9, 9, 2])];
  clouds.take(wider);
  expect(wider[1]).toEqual({
    type: "SceneNodeUpdateMessage",
    name: "/points/points",
    owner: "",
    updates: { points: new Float32Array([0, 0, 0, -1, 0.5, 2]), colors: new Uint8Array([1, 2, 3, 7, 8, 9]) },
  });
});

test("a cloud without a box stays whole, and one that is removed is forgotten", () => {
  const clouds = new ClippedClouds();
  const whole = [cloud()];
  clouds.take(whole);
  expect(whole[0]?.props?.points).toBe(POINTS);
  const boxed = [corner("low", [0, 0, 0]), corner("high", [1, 1, 1])];
  clouds.take([{ type: "RemoveSceneNodeMessage", name: "/points/points" }]);
  clouds.take(boxed);
  expect(boxed).toHaveLength(2);
});
