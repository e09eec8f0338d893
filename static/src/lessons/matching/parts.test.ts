import { describe, expect, it } from "vitest";
import type { Point, Pose } from "../../wire/protocol";
import { apart } from "./matching";
import { nearestPairs, placed } from "./model";
import { ransac, split, wallsOf } from "./ransac";
import { problemIn, scanFromPose } from "./world";

const DEGREE = Math.PI / 180;

describe("straight parts", () => {
  it("splits two sides of a corner at the corner", () => {
    const points: Point[] = [...Array(6).keys()].map((k) => [k, 0]);
    points.push(...[1, 2, 3, 4].map((k): Point => [5, k]));
    expect(split(points, 0.1, 3)).toEqual([
      [0, 5],
      [5, 9],
    ]);
    expect(split(points.slice(0, 6), 0.1, 3)).toEqual([[0, 5]]);
    expect(split(points.slice(0, 2), 0.1, 3)).toEqual([]);
  });

  it("finds the walls of the room, each along x or y", () => {
    const walls = wallsOf(scanFromPose([1.9, 2.5, 0.3], 1), 0.5, 0.06, 5);
    expect(walls.length).toBeGreaterThan(4);
    for (const [[ax, ay], [bx, by]] of walls) expect(Math.min(Math.abs(ax - bx), Math.abs(ay - by))).toBeLessThan(0.08);
  });
});

describe("a pose from pairs of which a third is wrong", () => {
  it("is that of the others", () => {
    const { fixed } = problemIn("room");
    const moving = placed(fixed, [0.4, -0.3, 12 * DEGREE] as Pose);
    const beams = [...fixed.isPoint.keys()].filter((k) => fixed.isPoint[k] === 1);
    const theirs = beams.map((k, i) => (i % 3 === 0 ? (beams[(i + 20) % beams.length] ?? 0) : k));
    const { pose, isInlier } = ransac(moving, fixed, { ours: beams, theirs }, 0.1, 60);
    const back = placed(moving, pose);
    expect(
      Math.max(
        ...beams.map((k) => Math.hypot((back.x[k] ?? 0) - (fixed.x[k] ?? 0), (back.y[k] ?? 0) - (fixed.y[k] ?? 0))),
      ),
    ).toBeLessThan(1e-6);
    expect(isInlier.filter(Boolean).length).toBeGreaterThanOrEqual(beams.length - Math.ceil(beams.length / 3));
  });

  it("leaves pairs of a poor start out", () => {
    const { fixed, moving, start, truth } = problemIn("room");
    const pairs = nearestPairs(moving, start, fixed, 1);
    const { pose } = ransac(moving, fixed, pairs, 0.15, 400);
    expect(apart(pose, truth).distance).toBeLessThan(apart(start, truth).distance);
  });
});
