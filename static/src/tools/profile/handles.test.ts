import { describe, expect, it } from "vitest";
import { beamModel, halfWindow, INITIAL_PARAMETERS, type SensorModelParameters } from "../../grid/sensorModel";
import vectors from "../../grid/sensorModel.vectors.json";
import { ticks, toPixel, toValue } from "../../render/chart/scale";
import type { Range } from "../../ui/numbers";
import { type Bounds, dragEdge, dragLevel, dragOpening, dragRangeMax, keyEdge, keyLevel } from "./handles";
import { extentFor, lensFor, lensKeeping, lensSpan } from "./layout";

const bounds: Bounds = (name) => (vectors.table as unknown as Record<string, Range>)[name] as Range;

describe("dragging a handle", () => {
  it("moves both edges of the window about the reading", () => {
    expect(dragEdge("far", 5.15, 5, bounds)).toEqual({ name: "window", value: 0.3 });
    expect(dragEdge("near", 4.85, 5, bounds)).toEqual({ name: "window", value: 0.3 });
    expect(dragEdge("far", 4.2, 5, bounds).value).toBe(0); // pulled through the reading
    expect(dragEdge("far", 9, 5, bounds).value).toBe(2);
    expect(dragEdge("far", 5.017, 5, bounds, true).value).toBe(0.03);
  });

  it("keeps evidence on its side of the prior", () => {
    expect(dragLevel("hit", 1.234, INITIAL_PARAMETERS, bounds)).toEqual({ name: "log_odds_hit", value: 1.25 });
    expect(dragLevel("hit", -1, INITIAL_PARAMETERS, bounds).value).toBe(0);
    expect(dragLevel("miss", 1, INITIAL_PARAMETERS, bounds).value).toBe(0);
    const step: SensorModelParameters = { ...INITIAL_PARAMETERS, model: "step_window", log_odds_prior: -0.3 };
    expect(dragLevel("hit", 1.4, step, bounds)).toEqual({ name: "p_occ", value: 0.75 }); // p(1.4 − 0.3)
    expect(dragLevel("miss", 0.5, step, bounds).value).toBeLessThanOrEqual(1 / (1 + Math.exp(0.3)));
  });

  it("sets the spread of a ramp, and the weight of a prior that makes a first visit change so much", () => {
    const ramp: SensorModelParameters = { ...INITIAL_PARAMETERS, model: "smooth_ramp", sigma_growth: 0.01 };
    const edge = dragEdge("far", 5.3, 5, bounds, false, ramp);
    expect(edge).toEqual({ name: "sigma", value: 0.1 });
    expect(5 + halfWindow(5, { ...ramp, sigma: edge.value })).toBeCloseTo(5.3, 9);
    const counting: SensorModelParameters = { ...INITIAL_PARAMETERS, model: "hit_counting", log_odds_prior: -0.4 };
    for (const [which, evidence] of [
      ["hit", 0.5],
      ["miss", -0.9],
    ] as const) {
      const { name, value } = dragLevel(which, evidence, counting, bounds, true);
      expect(name).toBe("prior_weight");
      expect(beamModel({ ...counting, prior_weight: value })[which]).toBeCloseTo(evidence, 1);
    }
    const up = keyLevel("hit", "ArrowUp", false, counting, bounds)?.value ?? Number.NaN;
    expect(beamModel({ ...counting, prior_weight: up }).hit).toBeGreaterThan(beamModel(counting).hit);
  });

  it("opens a cone so far that its edge passes the hand", () => {
    expect(dragOpening(100, 36.4, bounds, true).value).toBeCloseTo(0.6981, 2);
    expect(dragOpening(100, -36.4, bounds, true).value).toBeCloseTo(0.6981, 2);
    expect(dragOpening(-5, 36.4, bounds).value).toBeCloseTo(bounds("opening").high, 4);
  });

  it("keeps the max range within the table's bounds", () => {
    expect(dragRangeMax(-4, bounds).value).toBe(0.5);
    expect(dragRangeMax(12.34, bounds)).toEqual({ name: "range_max", value: 12.3 });
  });

  it("answers keys where the arrow points", () => {
    const values = { ...INITIAL_PARAMETERS, window: 0.2 };
    expect(keyEdge("far", "ArrowRight", false, values, bounds)?.value).toBe(0.25);
    expect(keyEdge("near", "ArrowRight", false, values, bounds)?.value).toBe(0.15);
    expect(keyEdge("near", "ArrowLeft", true, values, bounds)?.value).toBe(0.21);
    expect(keyLevel("miss", "ArrowDown", false, INITIAL_PARAMETERS, bounds)?.value).toBe(-0.45);
    expect(keyLevel("hit", "Tab", false, INITIAL_PARAMETERS, bounds)).toBeNull();
  });
});

describe("the lens", () => {
  it("stays while the reading is well inside, and follows when it is not", () => {
    const before = { start: 3, span: 2.4 };
    expect(lensFor(4.5, 2.4, 37, before)).toBe(before);
    const after = lensFor(9, 2.4, 37, before);
    expect(after.start).toBeLessThan(9);
    expect(after.start + after.span).toBeGreaterThan(9);
    expect(lensFor(0.1, 2.4, 37, before).start).toBe(0);
  });

  it("shows the whole window, and never more than the beam", () => {
    expect(lensSpan(0.01, 2, 37, 900)).toBeGreaterThan(2);
    expect(lensSpan(1, 0, 37, 900)).toBe(37);
  });

  it("goes along with a reading that is dragged out of it", () => {
    expect(lensKeeping(4, { start: 3, span: 2 })).toEqual({ start: 3, span: 2 });
    expect(lensKeeping(6, { start: 3, span: 2 }).start).toBeCloseTo(4.16, 9);
  });

  it("has axes that go both ways and round ticks", () => {
    const scale = { low: -1.2, high: 1.2, from: 300, to: 100 };
    expect(toValue(toPixel(0.85, scale), scale)).toBeCloseTo(0.85, 12);
    expect(ticks(-1.2, 1.2, 6)).toEqual([-1, -0.5, 0, 0.5, 1]);
    expect(extentFor(0.85)).toBe(1.2);
    expect(extentFor(-3)).toBe(5);
  });
});
