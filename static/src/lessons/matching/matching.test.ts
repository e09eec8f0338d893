import { describe, expect, it } from "vitest";
import { centreOf } from "../../grid/lattice";
import {
  apart,
  ELSEWHERE,
  endOf,
  judged,
  oneStep,
  STARTS,
  scoreAt,
  scoreLandscape,
  snapped,
  TRUE_POSE,
  toTheEnd,
} from "./matching";
import { GEOMETRY, problemIn } from "./world";

const DEGREE = Math.PI / 180;

describe("the figure of two scans", () => {
  it.each(["point_to_point", "point_to_line"] as const)("finds the pose from the start by %s", (method) => {
    const problem = problemIn("room");
    const { pose, steps } = toTheEnd(problem, method, problem.start);
    const { distance, turn } = apart(pose, problem.truth);
    expect(distance).toBeLessThan(0.05);
    expect(turn).toBeLessThan(2 * DEGREE);
    expect(steps).toBeGreaterThan(1);
    expect(scoreAt(problem, pose)).toBeGreaterThan(scoreAt(problem, problem.start));
  });

  it("finds the best cell by correlation", () => {
    const problem = problemIn("room");
    const { distance, turn } = apart(oneStep(problem, "correlative", problem.start), problem.truth);
    expect(distance).toBeLessThan(0.08);
    expect(turn).toBeLessThan(2.6 * DEGREE);
  });

  it("knows the direction that a corridor hides", () => {
    const problem = problemIn("corridor");
    const along = judged(problem, problem.truth).unknown ?? [0, 0, 0];
    expect(Math.abs(along[0])).toBeGreaterThan(0.99);
    expect(judged(problemIn("room"), problemIn("room").truth).unknown).toBeNull();
    // Across the corridor the pose is found, along it the match stays where it began.
    const { pose } = toTheEnd(problem, "point_to_line", problem.start);
    expect(pose[1]).toBeCloseTo(problem.truth[1], 1);
    expect(Math.abs(pose[0] - problem.truth[0])).toBeGreaterThan(0.5);
  });

  it("has two poses with one score in a symmetric room", () => {
    const problem = problemIn("symmetric");
    const { pose } = toTheEnd(problem, "point_to_line", problem.start);
    expect(apart(pose, problem.truth).turn).toBeGreaterThan(170 * DEGREE);
    expect(scoreAt(problem, pose)).toBeCloseTo(scoreAt(problem, problem.truth), 1);
  });

  it("fails from too far away", () => {
    const problem = problemIn("far");
    for (const method of ["point_to_point", "point_to_line", "correlative"] as const)
      expect(apart(toTheEnd(problem, method, problem.start).pose, problem.truth).distance).toBeGreaterThan(0.3);
  });

  it("finds the pose though the table was moved", () => {
    const problem = problemIn("table");
    const { pose } = toTheEnd(problem, "point_to_line", problem.start);
    expect(apart(pose, problem.truth).distance).toBeLessThan(0.08);
  });

  it("snaps near the pose only", () => {
    const problem = problemIn("room");
    const [x, y, heading] = problem.truth;
    expect(snapped(problem, "point_to_line", [x + 0.2, y - 0.1, heading + 0.1])).not.toBeNull();
    expect(snapped(problem, "point_to_line", [x - 1.6, y + 0.4, heading])).toBeNull();
  });

  it("has its highest score at the true position", () => {
    const problem = problemIn("room");
    const scores = scoreLandscape(problem, problem.truth[2]);
    const best = scores.indexOf(Math.max(...scores));
    const [x, y] = centreOf(GEOMETRY, { row: Math.floor(best / GEOMETRY.cols), col: best % GEOMETRY.cols });
    expect(Math.hypot(x - problem.truth[0], y - problem.truth[1])).toBeLessThan(0.1);
  });

  it("says where a start ends", () => {
    const problem = problemIn("room");
    const cellOf = (x: number, y: number): number => Math.floor(y / 0.2) * STARTS.cols + Math.floor(x / 0.2);
    expect(endOf(problem, "point_to_line", problem.truth[2], cellOf(3.0, 2.7))).toBe(TRUE_POSE);
    expect(endOf(problem, "correlative", problem.truth[2], cellOf(5.9, 0.5))).toBe(ELSEWHERE);
  });
});
