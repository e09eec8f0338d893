import { expect, test } from "vitest";
import type { LocalizationMessage } from "../../wire/protocol";
import { ellipseOf, type Given, grown, isOn, type Point, SETTINGS, type Setting, turned } from "./model";

const message = (n_updates: number, error_m: number | null = 1, is_on = true): LocalizationMessage =>
  ({ type: "localization", is_on, n_updates, error_m, entropy: 3 }) as unknown as LocalizationMessage;

test("the history has a point for each scan that was used", () => {
  let points: readonly Point[] = [];
  for (const [updates, error] of [
    [1, 5],
    [1, 4],
    [2, 3],
  ] as const)
    points = grown(points, message(updates, error));
  expect(points).toEqual([
    { updates: 1, error: 5, entropy: 3 },
    { updates: 2, error: 3, entropy: 3 },
  ]);
});

test("a filter that begins again, or ends, begins the history again", () => {
  const points = grown(grown([], message(7)), message(8));
  expect(grown(points, message(1))).toHaveLength(1);
  expect(grown(points, message(8, null, false))).toEqual([]);
});

const setting = (name: string): Setting => SETTINGS.find((setting) => setting.name === name) as Setting;
const plain: Given = { values: { alpha1: 0.4 }, map: "plan", world: "office" };
const on = (given: Given): readonly string[] =>
  SETTINGS.filter((setting) => isOn(setting, given)).map(({ name }) => name);

test("settings are on together, and each ends alone", () => {
  const few = turned(setting("few"), plain, "room");
  const both = turned(setting("sure"), few, "room");
  expect(both.values).toEqual({ alpha1: 0.4, ...setting("few").values, ...setting("sure").values });
  expect(on(both)).toEqual(["few", "sure", "no-recovery"]);
  // What the other one sets too stays.
  const sure = turned(setting("few"), both, "room");
  expect(sure.values).toEqual({ alpha1: 0.4, ...setting("sure").values });
  expect(turned(setting("sure"), sure, "room")).toEqual(plain);
});

test("a setting with a world of its own goes there and leaves it", () => {
  const twins = turned(setting("twins"), plain, "room");
  expect(twins.world).toBe("twins");
  expect(turned(setting("twins"), twins, "room").world).toBe("room");
});

test("an ellipse along the line of greatest variance", () => {
  const [long, short, turn] = ellipseOf(0.04, 0, 0.01);
  expect(long).toBeCloseTo(0.2 * Math.sqrt(5.991));
  expect(short).toBeCloseTo(0.1 * Math.sqrt(5.991));
  expect(turn).toBeCloseTo(0);
  const [, none, diagonal] = ellipseOf(1, 1, 1);
  expect(none).toBeCloseTo(0);
  expect(diagonal).toBeCloseTo(Math.PI / 4);
});

test("one setting says which map the filter gets", () => {
  const other = turned(setting("other"), turned(setting("moved"), plain, "room"), "room");
  expect([other.map, ...on(other)]).toEqual(["other", "other"]);
  expect(turned(setting("other"), other, "room").map).toBe("plan");
});
