import { describe, expect, it } from "vitest";
import { brokenAtGaps, isInGap, isolatedRows, united } from "./gaps";

const series = {
  times: [0, 1, 2, 60, 120, 121, 300],
  gaps: [
    [2, 60],
    [60, 120],
    [121, 300],
  ] as const,
};

describe("a line over a recording with gaps", () => {
  // A chart of 10 canvas px for a second, whose frame begins at 50.
  const chart = { valToPos: (at: number) => 50 + 10 * at, data: [series.times, [1, 2, 3, 4, null, 6, 7]] };
  const line = (spansMissing: boolean) =>
    brokenAtGaps(series, spansMissing) as unknown as {
      gaps: (chart: unknown, line: number, first: number, last: number, missing: number[][]) => number[][];
      points: { filter: (chart: unknown, line: number) => number[] | null };
    };

  it("is cut from the sample before a gap to the one after it", () => {
    expect(line(true).gaps(chart, 1, 0, 6, [[1250, 1260]])).toEqual([
      [70, 1250],
      [1260, 3050],
    ]);
  });

  it("is cut at missing values too where that is asked for", () => {
    expect(
      line(false).gaps(chart, 1, 0, 6, [
        [60, 70],
        [1250, 1260],
      ]),
    ).toEqual([[60, 3050]]);
  });

  it("is a point where it has one sample", () => {
    expect(line(true).points.filter(chart, 1)).toEqual([3, 5, 6]);
    expect(isolatedRows(series, [1, 2, 3, null, 5, 6, 7])).toEqual([6]);
    expect(isolatedRows({ times: [0, 1], gaps: [] }, [1, 2])).toEqual([]);
  });
});

describe("a moment in a gap", () => {
  it("is between the two samples", () => {
    expect([2, 3, 60, 121, 299.9, 301].map((at) => isInGap(series.gaps, at))).toEqual([
      false,
      true,
      false,
      false,
      true,
      false,
    ]);
  });
});

describe("spans", () => {
  it("are united where they overlap, in whatever order they come", () => {
    expect(
      united([
        [5, 9],
        [0, 2],
        [6, 7],
        [2, 3],
      ]),
    ).toEqual([
      [0, 3],
      [5, 9],
    ]);
  });
});
