import { describe, expect, it } from "vitest";
import { gapAt, indexAfter, keyedIndex, reordered } from "./deckOrder";

describe("a slide that is moved", () => {
  const rows = [0, 10, 20, 30].map((top) => ({ top, bottom: top + 10 }));

  it.each([
    ["above all", 2, -5, "CABD"],
    ["into the gap above itself", 2, 16, "ABCD"],
    ["into the gap below itself", 2, 34, "ABCD"],
    ["below all", 2, 99, "ABDC"],
    ["one up", 2, 6, "ACBD"],
  ])("goes %s", (_, from, y, wanted) => {
    expect(reordered([..."ABCD"], from, indexAfter(from, gapAt(y, rows))).join("")).toBe(wanted);
  });

  it("goes by keys and stays at the ends", () => {
    expect(["ArrowUp", "ArrowDown", "Home", "End", "a"].map((key) => keyedIndex(key, 0, 4))).toEqual([
      0,
      1,
      0,
      3,
      null,
    ]);
    expect(keyedIndex("ArrowDown", 3, 4)).toBe(3);
  });
});
