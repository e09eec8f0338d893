import { describe, expect, it } from "vitest";
import { gapAt, indexAfter, keyedIndex, numberOf, only, reordered, shown } from "./deckOrder";

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

  it("is not dropped among rows that are not displayed", () => {
    const some = [0, 10, 0, 0, 20].map((top, i) =>
      i === 2 || i === 3 ? { top, bottom: 0 } : { top, bottom: top + 10 },
    );
    expect([-1, 8, 18, 99].map((y) => gapAt(y, some))).toEqual([0, 1, 4, 5]);
  });

  it("goes by keys and stays at the ends", () => {
    const all = [true, true, true, true];
    const to = ["ArrowUp", "ArrowDown", "Home", "End", "a"].map((key) => keyedIndex(key, 0, all));
    expect(to).toEqual([0, 1, 0, 3, null]);
    expect(keyedIndex("ArrowDown", 3, all)).toBe(3);
  });

  it("goes past hidden slides, and stays where no other one is shown", () => {
    const some = [true, false, false, true, false];
    expect(keyedIndex("ArrowDown", 0, some)).toBe(3);
    expect(keyedIndex("ArrowUp", 3, some)).toBe(0);
    expect(keyedIndex("ArrowDown", 3, some)).toBe(3);
    expect(keyedIndex("ArrowDown", 1, some)).toBe(2); // a hidden one by one row
  });
});

it("slides are numbered as they are shown", () => {
  expect([0, 3, 5].map((index) => numberOf([true, false, false, true, false, true], index))).toEqual([1, 2, 3]);
});

it("a short deck begins with one slide, and all can be shown again", () => {
  const slides: readonly { name: string; hidden?: boolean }[] = [
    { name: "A" },
    { name: "B", hidden: true },
    { name: "C" },
  ];
  const first = only(slides, (_, i) => i === 1);
  expect(first).toEqual([{ name: "A", hidden: true }, { name: "B" }, { name: "C", hidden: true }]);
  expect(first.map(shown)).toEqual([{ name: "A" }, { name: "B" }, { name: "C" }]);
});
