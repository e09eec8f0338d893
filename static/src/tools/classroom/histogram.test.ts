import { describe, expect, it } from "vitest";
import { barsOf, spoken } from "./histogram";

const base = { id: 1, text: "?", is_revealed: true, is_closed: true, answered: 4 } as const;

describe("barsOf", () => {
  it("gives each option its share of the most frequent one", () => {
    const bars = barsOf({ ...base, options: ["a", "b", "c"], axis: null, counts: [1, 3, 0], right: 1 });
    expect(bars.map((bar) => [bar.label, bar.length, bar.isRight])).toEqual([
      ["a", 1 / 3, false],
      ["b", 1, true],
      ["c", 0, false],
    ]);
  });

  it("divides the axis evenly, and finds the part of the right number, its end too", () => {
    const axis = { low: 0, high: 100, unit: "scans" };
    const bars = barsOf({ ...base, options: null, axis, counts: [0, 2, 1, 1], right: 100 });
    expect(bars.map((bar) => bar.label)).toEqual(["0 to 25", "25 to 50", "50 to 75", "75 to 100"]);
    expect(bars.map((bar) => bar.isRight)).toEqual([false, false, false, true]);
  });

  it("has no bars before the reveal", () => {
    const hidden = { ...base, options: ["a", "b"], axis: null, counts: null, right: null };
    expect(barsOf(hidden)).toEqual([]);
    expect(spoken(hidden)).toBe("4 answered.");
  });
});
