import { describe, expect, it } from "vitest";
import type { Pose } from "../../wire/protocol";
import { gridBefore, runProgram, stepFrom } from "./model";
import vectors from "./program.vectors.json";
import { linesOf, PROGRAM, SHOWN } from "./source";

const GEOMETRY = { ...vectors.geometry, origin: vectors.geometry.origin as unknown as Pose };
const SCAN = {
  ranges: Float32Array.from(vectors.ranges, (value) => (value === "inf" ? Number.POSITIVE_INFINITY : Number(value))),
  angle_min: -0.7,
  angle_increment: 0.45,
  range_min: 0.05,
  range_max: 3,
};
const run = runProgram(GEOMETRY, SCAN, vectors.pose as unknown as Pose);

describe("the program, line by line", () => {
  it("runs the lines that Python runs, one by one", () => {
    expect(run.steps.map(({ fn, offset }) => [fn, offset])).toEqual(vectors.lines);
  });

  it("makes the map that Python makes", () => {
    const { logOdds, observed } = gridBefore(run, run.steps.length - 1);
    const seen = [...observed.keys()].filter((i) => observed[i] === 1);
    expect(seen).toEqual(vectors.cells.map(([index]) => index));
    for (const [index, value] of vectors.cells) expect(logOdds[index as number]).toBeCloseTo(value as number, 6);
  });

  it("goes on by lines, cells, beams and the scan, and back again", () => {
    expect(stepFrom(run, 5, "line", 1)).toBe(6);
    expect(stepFrom(run, 5, "scan", 1)).toBe(run.steps.length - 1);
    expect(stepFrom(run, 5, "scan", -1)).toBe(0);
    const beams = [0];
    while ((beams.at(-1) as number) < run.steps.length - 1)
      beams.push(stepFrom(run, beams.at(-1) as number, "beam", 1));
    expect(beams.slice(1, -1).map((step) => run.steps[step]?.beam)).toEqual([0, 1, 2, 3, 4, 5]);
    const cell = stepFrom(run, 0, "cell", 1);
    expect(run.steps[cell]).toMatchObject({ fn: "update", current: 0, done: 0 });
    expect(run.steps[stepFrom(run, cell, "cell", 1)]).toMatchObject({ current: 1, done: 1 });
    expect(stepFrom(run, stepFrom(run, cell, "cell", 1), "cell", -1)).toBe(cell);
  });
});

describe("the program's text", () => {
  it("is the file's, from def to the last line, without docstrings", () => {
    const [first] = PROGRAM;
    expect(first?.[0]?.text).toMatch(/^def update_per_beam\(/);
    expect(first?.at(-1)?.text).toBe("    return updates");
    for (const [i, fn] of SHOWN.entries()) {
      expect(PROGRAM[i]?.[0]?.text.startsWith(`def ${fn}(`)).toBe(true);
      expect(PROGRAM[i]?.some((line) => line.text.includes('"""'))).toBe(false);
    }
  });

  it("counts lines from the def, docstrings of any length left out", () => {
    const source =
      'def update(\n    a: int,\n) -> int:\n    """One.\n\n    Two\n    """\n    b = a\n\n    return b\n\n\ndef x():\n';
    expect(linesOf("update", source).map(({ offset, text }) => [offset, text])).toEqual([
      [0, "def update("],
      [1, "    a: int,"],
      [2, ") -> int:"],
      [7, "    b = a"],
      [8, ""],
      [9, "    return b"],
    ]);
  });
});
