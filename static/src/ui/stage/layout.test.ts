import { expect, test } from "vitest";
import { arranged, layoutOf, read, withAdded, withView, written } from "./layout";

const KINDS = ["map", "picture", "3d", "plots", "frames"];

test("a layout is read as it was written", () => {
  const layout = { ...layoutOf("four", ["map", "picture", "3d", "plots"]), x: 0.6, y: 0.3 };
  expect(written(layout)).toBe("four:map,picture,3d,plots:60:30");
  expect(read(written(layout), KINDS)).toEqual(layout);
});

test("a text that is no layout is none", () => {
  const wrong = ["", "five:map:50:50", "beside:map:50:50", "beside:map,map:50:50", "one:map,3d:50:50"];
  expect(wrong.map((text) => read(text, KINDS))).toEqual(wrong.map(() => null));
  expect(read("one:map:0:x", KINDS)).toEqual(layoutOf("one", ["map"]));
});

test("a view that is not there gives its place to another one", () => {
  expect(read("beside:3d,plots:60:50", ["map", "plots"])).toEqual({ ...layoutOf("beside", ["map", "plots"]), x: 0.6 });
  expect(read("four:map,3d,radar,plots:50:50", KINDS)?.views).toEqual(["map", "3d", "picture", "plots"]);
  expect(read("four:map,3d,radar,plots:50:50", ["map", "plots", "frames"])).toBeNull();
});

test("another arrangement keeps the views that it has room for", () => {
  const two = layoutOf("beside", ["picture", "map"]);
  expect(arranged(two, "four", KINDS).views).toEqual(["picture", "map", "3d", "plots"]);
  expect(arranged(two, "one", KINDS).views).toEqual(["picture"]);
});

test("a view is added beside the only one, or in the place of the last", () => {
  expect(written(withAdded(layoutOf("one", ["map"]), "3d"))).toBe("beside:map,3d:50:50");
  expect(withAdded(layoutOf("four", ["map", "picture", "plots", "frames"]), "3d").views).toEqual([
    "map",
    "picture",
    "plots",
    "3d",
  ]);
  const has = layoutOf("above", ["3d", "map"]);
  expect(withAdded(has, "3d")).toBe(has);
});

test("a view that has a place already changes it with the other one", () => {
  const two = layoutOf("beside", ["map", "picture"]);
  expect(withView(two, 1, "plots").views).toEqual(["map", "plots"]);
  expect(withView(two, 1, "map").views).toEqual(["picture", "map"]);
});
