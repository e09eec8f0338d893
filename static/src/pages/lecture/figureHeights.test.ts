// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { figureHeight, heightAt } from "./figureHeights";
import HEIGHTS from "./figureHeights.json";
import { LESSONS } from "./lessons";

test("between two points the height is interpolated, outside it is constant", () => {
  const points = [
    [320, 500],
    [720, 300],
    [721, 400],
  ];
  expect([200, 320, 420, 720, 721, 2000].map((width) => heightAt(points, width))).toEqual([
    500, 500, 450, 300, 400, 400,
  ]);
});

test("each section has heights, by increasing width, from the narrowest window to a wide one", () => {
  expect(Object.keys(HEIGHTS)).toEqual(LESSONS.map(({ id }) => id));
  for (const points of Object.values(HEIGHTS)) {
    const widths = points.map(([width = 0]) => width);
    expect(widths).toEqual([...new Set(widths)].sort((a, b) => a - b));
    expect([widths[0], widths.at(-1)]).toEqual([320, 2560]);
  }
  expect(figureHeight("no such section", 1000)).toBe(0);
});
