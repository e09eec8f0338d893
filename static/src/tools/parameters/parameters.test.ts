import { describe, expect, it } from "vitest";
import type { Parameter } from "../../wire/protocol";
import { boundsOf, grouped, isEnabled, isShown } from "./parameters";

const row = (over: Partial<Parameter>): Parameter => ({
  name: "x",
  label: "X",
  group: "model",
  kind: "number",
  initial: 0,
  sentence: "",
  unit: "",
  low: 0,
  high: 1,
  step: 0.01,
  choices: [],
  only_for: [],
  ...over,
});

describe("what a parameter panel shows", () => {
  const hit = row({ name: "log_odds_hit", only_for: ["fixed_increments"] });
  const free = row({ name: "p_free", low: 0.01, high: 0.99, only_for: ["step_window"] });

  it("hides rows of other models and choices without a choice", () => {
    expect(isShown(hit, { model: "fixed_increments" })).toBe(true);
    expect(isShown(hit, { model: "step_window" })).toBe(false);
    expect(isShown(row({ kind: "choice", choices: ["bresenham"] }), {})).toBe(false);
    const groups = grouped([hit, free, row({ name: "y", group: "map" })], { model: "step_window" });
    expect(groups.map((group) => [group.name, group.rows.map((row) => row.name)])).toEqual([
      ["model", ["p_free"]],
      ["map", ["y"]],
    ]);
  });

  it("shows the distance of RANSAC only with RANSAC", () => {
    const distance = row({ name: "fit_distance" });
    expect(isShown(distance, { fit: "ransac" })).toBe(true);
    expect(isShown(distance, { fit: "least_squares" })).toBe(false);
  });

  it("keeps the step window's probabilities on their side of the prior", () => {
    const values = { model: "step_window", log_odds_prior: -0.3, p_free: 0.2, p_occ: 0.8 };
    expect(boundsOf(free, values).high).toBeCloseTo(0.42, 9); // p(−0.3) = 0.4256
    expect(boundsOf({ ...free, name: "p_occ" }, values).low).toBeCloseTo(0.43, 9);
    const prior = boundsOf(row({ name: "log_odds_prior", low: -2, high: 2, step: 0.05 }), values);
    expect([prior.low, prior.high]).toEqual([expect.closeTo(-1.35, 9), expect.closeTo(1.35, 9)]);
  });

  it("rests the clamp's limits while the clamp is off", () => {
    expect(isEnabled(row({ name: "log_odds_min" }), { clamp: false })).toBe(false);
    expect(isEnabled(row({ name: "log_odds_min" }), { clamp: true })).toBe(true);
  });
});
