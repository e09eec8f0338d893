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
  expect(place.querySelectorAll(".readout-legend li").length).toBe(4);
  expect(place.querySelector("dl")).toBeNull();
  const voice = place.querySelector("[role=status]");
  expect(voice).not.toBeNull();
  const [x, y] = store.frame.value?.pose ?? [0, 0];
  await act(() => {
    store.pinned.value = [x, y];
  });
  expect(place.querySelector(".readout-legend")).toBeNull();
  expect(place.querySelector(".readout-state")?.textContent).toBe("free");
  // A screen reader announces changes of an element that was there before.
  expect(place.querySelector("[role=status]")).toBe(voice);
  await act(() => {
    store.pinned.value = null;
  });
  expect(place.querySelector(".readout-legend")).not.toBeNull();
  render(null, place);
});
