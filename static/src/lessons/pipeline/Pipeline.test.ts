import { describe, expect, it } from "vitest";
import { logOdds } from "../../grid/cellValues";
import { densityCharacter, stateCharacter } from "./Pipeline";

// @vitest-environment happy-dom

describe("a map of characters", () => {
  it("has three states at ±0.5 of log-odds", () => {
    expect([0.51, 0.5, 0, -0.5, -0.51].map(stateCharacter).join("")).toBe("#???.");
  });

  it("has six steps of probability", () => {
    const p = [0.95, 0.8, 0.6, 0.5, 0.35, 0.2, 0.05];
    expect(p.map((p) => densityCharacter(logOdds(p))).join("")).toBe("#o+ −..");
  });
});
