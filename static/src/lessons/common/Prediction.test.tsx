// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { type Classroom, classroom } from "../../store/classroom";
import { Prediction } from "./Prediction";

beforeEach(() => {
  class Observer {
    observe(): void {}
    disconnect(): void {}
  }
  vi.stubGlobal("IntersectionObserver", Observer);
  vi.stubGlobal("ResizeObserver", Observer);
});

afterEach(() => {
  render(null, document.body);
  classroom.value = null;
  vi.unstubAllGlobals();
});

/** Render a question, and press its button. */
async function pressed(reveal: () => number | Promise<number>): Promise<HTMLButtonElement> {
  act(() => render(h(Prediction, { text: "How many?", axis: { low: 0, high: 10 }, step: 1, reveal }), document.body));
  const button = document.querySelector<HTMLButtonElement>("button.primary");
  if (!button) throw new Error("no button");
  await act(() => button.click());
  return button;
}

const status = (): string => document.querySelector("[role=status]")?.textContent ?? "";

test("the button says that the result is computed before the computation begins", async () => {
  let text = "";
  await pressed(() => {
    text = document.querySelector("button.primary")?.textContent ?? "";
    return 7;
  });
  await vi.waitFor(() => expect(status()).toContain("It is 7."));
  expect(text).toBe("Computing …");
});

test("a result that cannot be loaded is said so, and can be asked for again", async () => {
  const reveal = vi.fn<() => Promise<number>>().mockRejectedValueOnce(new TypeError("Failed to fetch"));
  const button = await pressed(reveal.mockResolvedValueOnce(3));
  await vi.waitFor(() => expect(status()).toContain("could not be loaded"));
  expect(button.disabled).toBe(false);
  await act(() => button.click());
  await vi.waitFor(() => expect(status()).toContain("It is 3."));
  expect(status()).not.toContain("could not");
  expect(reveal).toHaveBeenCalledTimes(2);
});

test("the class is told the result, also after its answers were revealed without it, and once", async () => {
  const asked = { id: 1, text: "How many?", options: null, axis: { low: 0, high: 10, unit: "" }, answered: 1 };
  const question = signal({ ...asked, is_revealed: true, is_closed: true, counts: [1], right: null as number | null });
  const send = vi.fn();
  classroom.value = { isFollowed: false, question, send } as unknown as Classroom;
  await pressed(() => 7);
  await vi.waitFor(() => expect(send).toHaveBeenCalledWith({ type: "reveal", right: 7 }));
  await act(() => {
    question.value = { ...question.value, right: 7 };
  });
  expect(send).toHaveBeenCalledTimes(1);
});
