import { expect, test } from "vitest";
import { Store } from "../../../store/store";
import type { Frame, Hello } from "../../../wire/protocol";
import { cloudsAt } from "./SolidView";

// @vitest-environment happy-dom

/** A store of a session on a log that begins at a time and has scans for some seconds. */
function logStore(start_s: number | null, duration_s: number, n_scans: number): Store {
  const store = new Store(() => true);
  store.hello.value = { log: { start_s, duration_s, n_scans } } as unknown as Hello;
  return store;
}

function at(main: Store, stamp: number, index = 5): Store {
  main.frame.value = { stamp, index, count: 40 } as Frame;
  return main;
}

test("the clouds up to the time of the map are shown, as if they came at even intervals", () => {
  const clouds = logStore(102, 10, 11); // a cloud each second, from 2 s after the first scan on
  const main = logStore(100, 20, 40);
  expect(cloudsAt(clouds, main)).toBeNull();
  expect([0, 1.9, 2, 2.9, 3, 11.9, 12, 15].map((stamp) => cloudsAt(clouds, at(main, stamp)))).toEqual([
    0, 0, 1, 1, 2, 10, 11, 11,
  ]);
  expect(cloudsAt(clouds, at(main, 3, 40))).toBe(11);
});

test("without times all clouds are shown", () => {
  const main = at(logStore(100, 20, 40), 3);
  expect(cloudsAt(logStore(null, 10, 11), main)).toBe(11);
  expect(cloudsAt(logStore(100, 0, 1), main)).toBe(1);
});
