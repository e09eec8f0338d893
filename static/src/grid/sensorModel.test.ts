import { describe, expect, it } from "vitest";
import { probability } from "./cellValues";
import {
  type CellEvent,
  type CellParameters,
  cellIncrement,
  cellZone,
  hitCells,
  INITIAL_PARAMETERS,
  increment,
  isCone,
  logOddsHistory,
  readingsUntil,
  type SensorModelParameters,
} from "./sensorModel";
import vectors from "./sensorModel.vectors.json";

const cases = vectors.cases as readonly {
  readonly parameters: SensorModelParameters;
  readonly z: number;
  readonly s: readonly number[];
  readonly profile: readonly number[];
  readonly cells: readonly (number | null)[];
}[];

describe("the profile in the browser is the mapper's", () => {
  it.each(cases.map((sampled, n) => [n, sampled] as const))("along the beam, case %i", (_n, sampled) => {
    sampled.s.forEach((s, i) => {
      expect(increment(s, sampled.z, sampled.parameters)).toBeCloseTo(sampled.profile[i] as number, 7);
    });
  });

  it.each(cases.map((sampled, n) => [n, sampled] as const))("in every cell, case %i", (_n, sampled) => {
    sampled.cells.forEach((gained, index) => {
      const zone = cellZone(index, sampled.z, sampled.parameters);
      if (gained === null) expect([index, zone]).toEqual([index, "beyond"]);
      else if (!isCone(sampled.parameters)) expect([index, zone]).not.toEqual([index, "beyond"]);
      expect(cellIncrement(index, sampled.z, sampled.parameters)).toBeCloseTo(gained ?? 0, 4);
    });
  });

  it.each(vectors.fans.map((fan, n) => [n, fan] as const))("beside the axis of a cone, case %i", (_n, fan) => {
    fan.s.forEach((s, i) => {
      fan.theta.forEach((theta, k) => {
        const wanted = fan.increments[i]?.[k] as number;
        expect(increment(s, fan.z, fan.parameters, theta)).toBeCloseTo(wanted, 7);
      });
    });
  });

  it("starts from the table's first values", () => {
    const initial = Object.fromEntries(Object.entries(vectors.table).map(([name, row]) => [name, row.initial]));
    expect(INITIAL_PARAMETERS).toEqual(initial);
  });
});

describe("the cells of a hit", () => {
  it("are one cell, the endpoint's, for a window of nothing", () => {
    expect(hitCells(4.23, INITIAL_PARAMETERS)).toEqual([84, 84]);
  });

  it("are those whose centres the window holds, and the endpoint's", () => {
    expect(hitCells(4.23, { ...INITIAL_PARAMETERS, window: 0.2 })).toEqual([83, 86]);
  });

  it("are none for a beam without return", () => {
    expect(hitCells(Number.POSITIVE_INFINITY, INITIAL_PARAMETERS)).toBeNull();
    expect(hitCells(Number.NaN, INITIAL_PARAMETERS)).toBeNull();
  });
});

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
