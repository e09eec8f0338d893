import { describe, expect, it } from "vitest";
import { type CellEvent, type CellParameters, logOddsHistory, readingsUntil } from "./cellUpdate";
import { probability } from "./logOdds";
import { INITIAL_PARAMETERS } from "./sensorModel";

const VALUES: CellParameters = { ...INITIAL_PARAMETERS, clamp: true, log_odds_min: -2, log_odds_max: 3.5 };

/** Bayes' filter for one cell, written in probabilities: p(m|z) ∝ p(m) · p(m|zₜ) / p₀ (Probabilistic Robotics, 4.2). */
function bayes(events: readonly CellEvent[], pFree: number, pOcc: number, prior: number): number {
  let p = prior;
  for (const event of events) {
    const given = event === "hit" ? pOcc : pFree;
    const occupied = (p * given) / prior;
    const free = ((1 - p) * (1 - given)) / (1 - prior);
    p = occupied / (occupied + free);
  }
  return p;
}

describe("one cell", () => {
  it("is Bayes' filter in log-odds", () => {
    const values = { ...VALUES, model: "step_window", clamp: false, log_odds_prior: -0.3, p_free: 0.35, p_occ: 0.8 };
    const events: CellEvent[] = ["hit", "miss", "miss", "hit", "hit", "miss", "hit"];
    const last = logOddsHistory(events, values).at(-1) as number;
    expect(probability(last)).toBeCloseTo(bayes(events, 0.35, 0.8, probability(-0.3)), 12);
  });

  it("stays between the clamp's limits and can come back", () => {
    const hits: CellEvent[] = Array.from({ length: 50 }, () => "hit");
    expect(logOddsHistory(hits, VALUES).at(-1)).toBe(3.5);
    expect(logOddsHistory([...hits, "miss"], VALUES).at(-1)).toBeCloseTo(3.1, 12);
  });

  it("counts the readings that change its state", () => {
    expect(readingsUntil("miss", 3.5, Math.log(0.25 / 0.75), VALUES)).toBe(12);
    const path = logOddsHistory(
      Array.from({ length: 12 }, () => "miss" as const),
      { ...VALUES, log_odds_prior: 3.5 },
    );
    expect(path[11]).toBeGreaterThan(Math.log(0.25 / 0.75));
    expect(path[12]).toBeLessThan(Math.log(0.25 / 0.75));
    expect(readingsUntil("miss", 0, -1.1, { ...VALUES, log_odds_min: -1 })).toBeNull();
    expect(readingsUntil("hit", 0, 0.6, { ...VALUES, log_odds_hit: 0 })).toBeNull();
  });
});
