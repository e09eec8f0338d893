import { describe, expect, it } from "vitest";
import { logOdds } from "../../grid/logOdds";
import { emptyGrid } from "../../grid/occupancyGrid";
import { asText, densityCharacter, stateCharacter } from "./density";

describe("a map of characters", () => {
  it("has three states at ±0.5 of log-odds", () => {
    expect([0.51, 0.5, 0, -0.5, -0.51].map(stateCharacter).join("")).toBe("#???.");
  });

  it("has six steps of probability", () => {
    const p = [0.95, 0.8, 0.6, 0.5, 0.35, 0.2, 0.05];
    expect(p.map((one) => densityCharacter(logOdds(one))).join("")).toBe("#o+ −..");
  });

  it("begins with the row of the greatest y", () => {
    const grid = emptyGrid({ resolution: 1, rows: 2, cols: 3, origin: [0, 0, 0] });
    grid.logOdds.set([2, 0, -2], 0); // the lower row
    expect(asText(grid, stateCharacter)).toBe("???\n#?.");
  });
});
