// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { expect, test } from "vitest";
import { DepthImage } from "./views";

test("the next image is asked for when the last one is there or was refused", async () => {
  const place = document.createElement("div");
  const taken = (count: number) => act(() => render(<DepthImage session="a" taken={count} />, place));
  const image = (): HTMLImageElement => place.querySelector("img") as HTMLImageElement;
  const asked = (): string => image().src.split("?")[1] ?? "";
  await taken(3);
  await taken(4);
  await taken(5);
  expect(asked()).toBe("3");
  await act(() => void image().dispatchEvent(new Event("load")));
  expect(asked()).toBe("5");
  await act(() => void image().dispatchEvent(new Event("error")));
  expect(asked()).toBe("5");
  await taken(6);
  expect(asked()).toBe("6");
});
