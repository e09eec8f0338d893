import { expect, test } from "vitest";
import { fragmentOf, viewOf } from "./CostmapViewer";

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
