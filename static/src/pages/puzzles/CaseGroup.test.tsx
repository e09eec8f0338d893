// @vitest-environment happy-dom

import { signal } from "@preact/signals";
import { h, render } from "preact";
import { afterEach, expect, test, vi } from "vitest";
import type { Store } from "../../store/store";
import { ask } from "../../wire/ask";
import type { Attempt, OfferedPuzzle } from "../../wire/http";
import { Answer } from "./CaseGroup";

vi.mock("../../wire/ask", async (original) => ({ ...(await original<object>()), ask: vi.fn(async () => ({})) }));

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
      faulty: { resolution: 0.4, mount_yaw: 0 },
      faulty_trajectory: "odometry",
    },
  }) as unknown as Attempt;

function shown(attempt: Attempt, next: OfferedPuzzle | null) {
  const store = { hello: { value: null }, compared: signal<object | null>(null), setTogether: vi.fn(), send: vi.fn() };
  const onNext = vi.fn();
  render(
    h(Answer, { session: "s1", store: store as unknown as Store, attempt, onClose: undefined, next, onNext }),
    document.body,
  );
  const buttons = [...document.querySelectorAll("button")];
  return { store, onNext, buttons, names: buttons.map((button) => button.textContent?.trim()) };
}

test("who asked for the answer can have the map repaired", () => {
  const { store, buttons, names } = shown(given(false), null);
  expect(names).toEqual(["Repair the map", "Beside the faulty map"]);
  expect(document.body.textContent).toContain("A repair: resolution 0.05, mount_yaw −0.19, poses from cameras.");
  buttons[0]?.click();
  expect(store.setTogether).toHaveBeenCalledWith("repair", { resolution: 0.05, mount_yaw: -0.19 });
  expect(store.send).toHaveBeenCalledWith({ type: "trajectory", name: "cameras" });
});

test("who solved it goes on to the next puzzle", () => {
  const { onNext, buttons, names } = shown(given(true), { name: "ghost", level: 2, title: "After lunch", story: "" });
  expect(names).toEqual(["Next: After lunch", "Beside the faulty map", "Copy the result"]);
  expect(document.body.textContent).toContain("Solved: 80 of 100 points");
  expect(document.querySelector("q")?.textContent).toBe("Errors add up.");
  buttons[0]?.click();
  expect(onNext).toHaveBeenCalledWith("ghost");
});

test("the faulty map is shown beside the repaired one, and taken away again", async () => {
  const { store, buttons } = shown(given(true), null);
  const button = buttons.find(({ textContent }) => textContent?.includes("faulty"));
  button?.click();
  const path = { session_id: "s1" };
  expect(ask).toHaveBeenLastCalledWith("PUT /api/sessions/{session_id}/compare", path, {
    body: { values: { resolution: 0.4, mount_yaw: 0 }, trajectory: "odometry" },
  });
  store.compared.value = {};
  await vi.waitFor(() => expect(button?.getAttribute("aria-pressed")).toBe("true"));
  button?.click();
  expect(ask).toHaveBeenLastCalledWith("DELETE /api/sessions/{session_id}/compare", path);
});
