import { describe, expect, it } from "vitest";
import type { ErrorStatistics, TrajectoryErrors } from "../../../wire/http";
import { errorSeries, rowsOf } from "./errors";

const all = (value: number): ErrorStatistics => ({
  rmse: value,
  mean: value,
  median: value,
  std: value,
  min: value,
  max: value,
  sse: value,
});
const errors: TrajectoryErrors = {
  pairs: 2,
  alignment: { x: 0, y: 0, theta: 0, scale: 1 },
  absolute: { translation_m: all(0.5), rotation_rad: all(Math.PI / 2) },
  relative: { translation_m: all(0.1), rotation_rad: all(Math.PI), delta: 1, unit: "m", pairs: 1 },
  series: {
    absolute: { times: [0, 1], translation_m: [0.4, 0.6], rotation_rad: [0, Math.PI] },
    relative: { times: [1], translation_m: [0.1], rotation_rad: [Math.PI] },
  },
  paths: { reference: [], estimate: [], errors_m: [] },
};

describe("the errors of a trajectory", () => {
  it("are written in metres and degrees", () => {
    const rows = rowsOf(errors);
    expect(rows.map(([what, unit, figures]) => [what, unit, figures[0]])).toEqual([
      ["Absolute", "m", 0.5],
      ["Absolute", "°", 90],
      ["Relative, over 1 m", "m", 0.1],
      ["Relative, over 1 m", "°", 180],
    ]);
  });

  it("are plotted over time, places and headings apart", () => {
    const { times, columns } = errorSeries(errors, "absolute");
    expect(times).toEqual([0, 1]);
    expect(columns.map(({ unit, values }) => [unit, values])).toEqual([
      ["m", [0.4, 0.6]],
      ["°", [0, 180]],
    ]);
    expect(new Set(columns.map(({ plot }) => plot)).size).toBe(2);
  });
});
