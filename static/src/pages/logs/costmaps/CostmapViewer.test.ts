import { expect, test } from "vitest";
import { cellsByMeaning, fragmentOf, viewOf } from "./CostmapViewer";

// @vitest-environment happy-dom

test("a view comes back from its address", () => {
  const all = { topic: "/local_costmap/costmap", index: 42, view: null };
  expect(viewOf(fragmentOf(all))).toEqual(all);
  const part = { topic: "/a b&c=d", index: 1, view: { x: -1.25, y: 0, scale: 0.015 } };
  expect(viewOf(fragmentOf(part))).toEqual(part);
});

test("what is no view is none", () => {
  for (const wrong of ["", "#", "#costmap=2", "#topic=/a", "#costmap=0&topic=/a", "#costmap=1.5&topic=/a"])
    expect(viewOf(wrong)).toBeNull();
  const of = { topic: "/a", index: 3, view: null };
  expect(viewOf("#costmap=3&topic=/a&x=1&y=2")).toEqual(of);
  expect(viewOf("#costmap=3&topic=/a&x=1&y=2&scale=-1")).toEqual(of);
  expect(viewOf("#costmap=3&topic=/a&x=&y=2&scale=1")).toEqual(of);
});

test("cells are counted by the meaning of their costs; those that were not sent are without information", () => {
  const bytes = new Uint32Array(256); // byte 0 is no information, 1 … 255 are the costs 0 … 254
  for (const [cost, count] of [
    [0, 5],
    [1, 2],
    [252, 1],
    [253, 3],
    [254, 4],
  ] as const)
    bytes[cost + 1] = count;
  bytes[0] = 1000; // of the chunks, which are larger than the map
  expect(cellsByMeaning(bytes, 20)).toEqual([5, 3, 3, 4, 5]);
});
