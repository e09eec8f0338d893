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

test.each([0.9, 0.5, 0.35])("the label of a free part of %f m begins right of the axis", (before) => {
  const view = new ProfileView(signal({}), signal(3));
  view.width.value = 360;
  view.lens.value = { start: 3 - before, span: 2 };
  const controls = controlsFor(
    view,
    () => ({ low: -5, high: 5, step: 0.05 }),
    () => {},
  );
  render(h("svg", null, h(Curve, { view, controls })), document.body);
  const label = document.querySelector(".label-miss");
  expect(label?.textContent).toMatch(/p 0\.40/);
  const left = Number(label?.getAttribute("x")) - HALF * (label?.textContent?.length ?? 0);
  expect(left).toBeGreaterThanOrEqual(view.layout.value.curve.left);
  view.dispose();
});
