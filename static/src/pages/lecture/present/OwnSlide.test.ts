import { expect, test } from "vitest";
import { formulaOf } from "./OwnSlide";

// @vitest-environment happy-dom

test("a line between dollar signs is a formula, with indices, exponents and a minus sign", () => {
  expect(formulaOf("$p_t = 1 - e^{-x}$")).toEqual([
    { text: "p", place: "line" },
    { text: "t", place: "sub" },
    { text: " = 1 − e", place: "line" },
    { text: "−x", place: "sup" },
  ]);
  expect(formulaOf(" $ℓ_{t-1}$ ")).toEqual([
    { text: "ℓ", place: "line" },
    { text: "t−1", place: "sub" },
  ]);
});

test("other lines are none, and a mark at the end is kept", () => {
  expect(formulaOf("costs 5 $ and 6 $ more")).toBeNull();
  expect(formulaOf("$$")).toBeNull();
  expect(formulaOf("$a_$")).toEqual([
    { text: "a", place: "line" },
    { text: "_", place: "line" },
  ]);
});
