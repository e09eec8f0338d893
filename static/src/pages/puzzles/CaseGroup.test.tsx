// @vitest-environment happy-dom

import { h, render } from "preact";
import { afterEach, expect, test, vi } from "vitest";
import type { Store } from "../../store/store";
import type { Attempt, OfferedPuzzle } from "../../wire/http";
import { Answer } from "./CaseGroup";

afterEach(() => render(null, document.body));

const given = (is_solved: boolean): Attempt =>
  ({
    title: "Detours",
    points: is_solved ? 80 : 0,
    is_solved,
    wrong: [],
    hints: [],
    answer: {
      cause: "drift",
      label: "The poses drift",
      explanation: "Wheels slip.",
      lesson: "Errors add up.",
      section: "odometry",
      repair: { resolution: 0.05, mount_yaw: -0.19 },
      trajectory: "cameras",
    },
  }) as unknown as Attempt;

function shown(attempt: Attempt, next: OfferedPuzzle | null) {
  const store = { hello: { value: null }, setTogether: vi.fn(), send: vi.fn() };
  const onNext = vi.fn();
  render(h(Answer, { store: store as unknown as Store, attempt, onClose: undefined, next, onNext }), document.body);
  const buttons = [...document.querySelectorAll("button")];
  return { store, onNext, buttons, names: buttons.map((button) => button.textContent?.trim()) };
}

test("who asked for the answer can have the map repaired", () => {
  const { store, buttons, names } = shown(given(false), null);
  expect(names).toEqual(["Repair the map"]);
  expect(document.body.textContent).toContain("A repair: resolution 0.05, mount_yaw −0.19, poses from cameras.");
  buttons[0]?.click();
  expect(store.setTogether).toHaveBeenCalledWith("repair", { resolution: 0.05, mount_yaw: -0.19 });
  expect(store.send).toHaveBeenCalledWith({ type: "trajectory", name: "cameras" });
});

test("who solved it goes on to the next puzzle", () => {
  const { onNext, buttons, names } = shown(given(true), { name: "ghost", level: 2, title: "After lunch", story: "" });
  expect(names).toEqual(["Next: After lunch", "Copy the result"]);
  expect(document.body.textContent).toContain("Solved: 80 of 100 points");
  expect(document.querySelector("q")?.textContent).toBe("Errors add up.");
  buttons[0]?.click();
  expect(onNext).toHaveBeenCalledWith("ghost");
});
