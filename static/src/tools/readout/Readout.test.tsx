// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { expect, it } from "vitest";
import { firstPicture } from "../../store/firstPicture";
import { Readout } from "./Readout";

it("says what the colours mean until a cell is inspected, then its values", async () => {
  const store = firstPicture();
  const place = document.createElement("div");
  await act(() => render(<Readout store={store} />, place));
  const shown = (): string[] => [...place.querySelectorAll("[data-shown=true]")].map(({ className }) => className);
  expect(place.querySelectorAll(".readout-legend li").length).toBe(4);
  expect(shown()).toEqual(["readout-legend"]);
  const voice = place.querySelector("[role=status]");
  expect(voice).not.toBeNull();
  const [x, y] = store.frame.value?.pose ?? [0, 0];
  await act(() => {
    store.pinned.value = [x, y];
  });
  expect(shown()).toEqual(["readout-values"]);
  expect(place.querySelector(".readout-state")?.textContent).toBe("free");
  // A screen reader announces changes of an element that was there before.
  expect(place.querySelector("[role=status]")).toBe(voice);
  await act(() => {
    store.pinned.value = null;
  });
  expect(shown()).toEqual(["readout-legend"]);
  render(null, place);
});
