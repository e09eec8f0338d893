import { describe, expect, it } from "vitest";
import { logOdds, probability } from "../../grid/cellValues";
import { type BeamResult, gridMap, joint, likeliest, productOf, type SensorParameters } from "./model";

const SENSOR: SensorParameters = { prior: 0.2, sonarError: 0.05, beamError: 0.1 };
const beamResults = (...all: BeamResult[]): BeamResult[] => all;

describe("independent cells and the joint", () => {
  it("agree about one cell: there is nothing to depend on", () => {
    for (const result of beamResults("none", "passed", "ended")) {
      const [p] = joint([result], SENSOR).marginals;
      expect(probability(gridMap([result], SENSOR)[0] as number)).toBeCloseTo(p as number, 12);
    }
  });

  it("is Bayes' rule, computed by hand for two cells", () => {
    // Maps 00, 10, 01, 11 with prior .64, .16, .16, .04; the echo, then a beam that passes cell 0.
    const weights = [0.64 * 0.05 * 0.9, 0.16 * 0.95 * 0.1, 0.16 * 0.95 * 0.9, 0.04 * 0.95 * 0.1];
    const total = weights.reduce((a, b) => a + b, 0);
    joint(beamResults("passed", "none"), SENSOR).maps.forEach((p, map) => {
      expect(p).toBeCloseTo((weights[map] as number) / total, 12);
    });
  });

  it("only the joint increases the probability of the remaining cells on the arc", () => {
    const before = beamResults("none", "none", "none", "none", "none");
    const after = beamResults("passed", "passed", "none", "passed", "passed");
    const [jointBefore, jointAfter] = [joint(before, SENSOR), joint(after, SENSOR)];
    expect(jointAfter.marginals[2]).toBeGreaterThan((jointBefore.marginals[2] as number) + 0.3);
    expect(gridMap(after, SENSOR)[2]).toBeCloseTo(gridMap(before, SENSOR)[2] as number, 12);
    expect(productOf(0, gridMap(after, SENSOR))).toBeGreaterThan(3 * (jointAfter.maps[0] as number));
  });

  it("gives each kind of map a whole distribution", () => {
    const some = beamResults("passed", "none", "ended");
    const cells = gridMap(some, SENSOR);
    const sum = Array.from({ length: 8 }, (_, map) => productOf(map, cells)).reduce((a, b) => a + b, 0);
    expect(sum).toBeCloseTo(1, 12);
    expect(joint(some, SENSOR).maps.reduce((a, b) => a + b, 0)).toBeCloseTo(1, 12);
  });

  it("always shows the map without anything", () => {
    const shown = likeliest(beamResults("ended", "ended", "ended"), SENSOR, 3);
    expect(shown).toHaveLength(3);
    expect(shown.some((column) => column.map === 0)).toBe(true);
  });

  it("takes the narrow beam's evidence from its error", () => {
    const [none, ended] = [gridMap(beamResults("none"), SENSOR), gridMap(beamResults("ended"), SENSOR)];
    expect((ended[0] as number) - (none[0] as number)).toBeCloseTo(logOdds(0.9), 12);
  });
});
