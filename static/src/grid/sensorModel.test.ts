import { describe, expect, it } from "vitest";
import {
  cellIncrement,
  cellZone,
  hitCells,
  INITIAL_PARAMETERS,
  increment,
  isCone,
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
  it.each(cases.map((one, n) => [n, one] as const))("along the beam, case %i", (_n, one) => {
    one.s.forEach((s, i) => {
      expect(increment(s, one.z, one.parameters)).toBeCloseTo(one.profile[i] as number, 7);
    });
  });

  it.each(cases.map((one, n) => [n, one] as const))("in every cell, case %i", (_n, one) => {
    one.cells.forEach((gained, index) => {
      const zone = cellZone(index, one.z, one.parameters);
      if (gained === null) expect([index, zone]).toEqual([index, "beyond"]);
      else if (!isCone(one.parameters)) expect([index, zone]).not.toEqual([index, "beyond"]);
      expect(cellIncrement(index, one.z, one.parameters)).toBeCloseTo(gained ?? 0, 4);
    });
  });

  it.each(vectors.fans.map((one, n) => [n, one] as const))("beside the axis of a cone, case %i", (_n, one) => {
    one.s.forEach((s, i) => {
      one.theta.forEach((theta, k) => {
        const wanted = one.increments[i]?.[k] as number;
        expect(increment(s, one.z, one.parameters, theta)).toBeCloseTo(wanted, 7);
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
