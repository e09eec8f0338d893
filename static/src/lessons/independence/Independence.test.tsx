// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { render } from "preact";
import { act } from "preact/test-utils";
import { expect, it } from "vitest";
import { Independence } from "./Independence";

it("has its numbers beside the drawing, which is scaled to the figure's width, and not in it", async () => {
  const place = document.createElement("div");
  const sensor = signal({ prior: 0.2, sonarError: 0.05, beamError: 0.1 });
  await act(() => render(<Independence sensor={sensor} />, place));
  expect(place.querySelectorAll(".cone text").length).toBe(0);
  const numbers = [...place.querySelectorAll(".cone-box .joint-number")].map((element) => element.textContent);
  // Cells that the beam has not crossed are as probable as each other, and more so than those that it has passed.
  expect(numbers).toHaveLength(5);
  expect(numbers[2]).toBe(numbers[4]);
  expect(Number.parseFloat(numbers[2] ?? "")).toBeGreaterThan(Number.parseFloat(numbers[0] ?? ""));
  render(null, place);
});
