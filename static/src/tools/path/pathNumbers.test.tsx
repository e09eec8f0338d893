// @vitest-environment happy-dom
import { h, render } from "preact";
import { afterEach, expect, test } from "vitest";
import type { PathMessage } from "../../wire/protocol";
import { PathNumbers } from "./PathGroup";

afterEach(() => render(null, document.body));

function shown(path: PathMessage | null): Record<string, string> {
  render(h(PathNumbers, { path }), document.body);
  const rows = [...document.querySelectorAll("dl > div")];
  return Object.fromEntries(rows.map((row) => [...row.children].map((cell) => cell.textContent ?? "")));
}

test("before there is a goal it shows what a goal will tell", () => {
  expect(shown(null)).toEqual({ Path: "– m", "Travel time": "– s", Cost: "–", "Planned in": "– ms" });
});

test("a path has its numbers, and a speed limit where there is one", () => {
  const path = { length: 12.345, travel_s: 24.6, cost: 12345.6, plan_ms: 3.21, speed_limit: null } as PathMessage;
  const numbers = { Path: "12.3 m", "Travel time": "24.6 s", Cost: "12,346", "Planned in": "3.2 ms" };
  expect(shown(path)).toEqual(numbers);
  expect(shown({ ...path, speed_limit: "50 %" })).toEqual({ ...numbers, "Speed limit": "50 %" });
});
