// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";
import { Thresholds } from "./Thresholds";

afterEach(() => {
  render(null, document.body);
  vi.restoreAllMocks();
});

test("each bar has a width and lies in its bin, also in the 99 px that Chromium gives a picture of a whole page", () => {
  vi.spyOn(HTMLElement.prototype, "clientWidth", "get").mockReturnValue(99);
  act(() => render(<Thresholds readFree={signal(0.25)} />, document.body));
  const bars = [...document.querySelectorAll("rect.bar")];
  expect(bars.length).toBeGreaterThan(10);
  const bin = (99 - 28) / 50;
  for (const bar of bars) {
    const [x, width] = ["x", "width"].map((name) => Number(bar.getAttribute(name)) / bin) as [number, number];
    expect(width).toBeGreaterThan(0);
    expect(Math.floor(x - 14 / bin)).toBe(Math.floor(x + width - 14 / bin));
  }
});
