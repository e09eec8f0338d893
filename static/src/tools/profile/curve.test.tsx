// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { afterEach, expect, test } from "vitest";
import { Curve } from "./Curve";
import { controlsFor } from "./controls";
import { ProfileView } from "./view";

afterEach(() => render(null, document.body));

/** A little more than half the width of a character of the labels' font, pixels. */
const HALF = 3.2;

/** The extent of a label, pixels. */
function extent(name: string): readonly [number, number] {
  const label = document.querySelector(name);
  const [x, width] = [Number(label?.getAttribute("x")), 2 * HALF * (label?.textContent?.length ?? 0)];
  const left = { start: x, middle: x - width / 2, end: x - width }[label?.getAttribute("text-anchor") ?? "start"] ?? x;
  return [left, left + width];
}

test.each([
  [0.9, null],
  [0.5, null],
  [0.35, null],
  [1.2, 166],
  [0.9, 166],
  [0.65, 166],
  [0.5, 166],
])("labels of a free part of %f m are beside the axis and the arrow, in a height of %s", (before, height) => {
  const view = new ProfileView(signal({}), signal(3));
  view.width.value = 340;
  view.height.value = height;
  view.lens.value = { start: 3 - before, span: 2 };
  const controls = controlsFor(
    view,
    () => ({ low: -5, high: 5, step: 0.05 }),
    () => {},
  );
  render(h("svg", null, h(Curve, { view, controls })), document.body);
  const { left, right } = view.layout.value.curve;
  const window = Number(document.querySelector(".zone-hit")?.getAttribute("x"));
  const [miss, hit] = [extent(".label-miss"), extent(".label-hit")];
  expect(miss[0]).toBeGreaterThanOrEqual(left);
  expect(hit[0]).toBeGreaterThanOrEqual(left);
  expect(hit[1]).toBeLessThanOrEqual(right);
  const handle = Number(document.querySelector(".tone-miss .handle-mark")?.getAttribute("y"));
  const label = Number(document.querySelector(".label-miss")?.getAttribute("y"));
  const isBelow = label > handle;
  if (isBelow)
    expect(label - 11).toBeGreaterThanOrEqual(handle + 10); // not over its handle
  else expect(label).toBeLessThan(handle);
  if (height !== null && isBelow) expect(miss[1]).toBeLessThan(window - 15); // the arrow
  view.dispose();
});

test.each([0.6, 0.8, 0.9, 1, 1.05, 1.2, 1.4])(
  "the labels of a hit and of a miss are apart, after %f m of 1.75 m",
  (before) => {
    for (const width of [340, 576, 700]) {
      for (const height of [150, 170, 190, 220]) {
        const view = new ProfileView(signal({}), signal(3.75));
        view.width.value = width;
        view.height.value = height;
        view.lens.value = { start: 3.75 - before, span: 1.75 };
        const controls = controlsFor(
          view,
          () => ({ low: -5, high: 5, step: 0.05 }),
          () => {},
        );
        render(h("svg", null, h(Curve, { view, controls })), document.body);
        const y = (name: string): number => Number(document.querySelector(name)?.getAttribute("y"));
        const [miss, hit] = [extent(".label-miss"), extent(".label-hit")];
        const isApart = miss[1] < hit[0] || hit[1] < miss[0] || Math.abs(y(".label-miss") - y(".label-hit")) >= 14;
        expect(isApart, `${width} × ${height}: ${miss}, ${hit}`).toBe(true);
        render(null, document.body);
        view.dispose();
      }
    }
  },
);
