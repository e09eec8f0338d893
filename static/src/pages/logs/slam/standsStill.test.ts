import { describe, expect, it } from "vitest";
import { standsStill } from "./standsStill";

describe("poses at one place", () => {
  it("are those of a log that states none", () => {
    expect(standsStill([])).toBe(false);
    expect(standsStill([[1, 2]])).toBe(false);
    expect(
      standsStill([
        [0, 0],
        [0, 0],
        [0, 0],
      ]),
    ).toBe(true);
    expect(
      standsStill([
        [0, 0],
        [0, 0.001],
      ]),
    ).toBe(false);
  });
});
