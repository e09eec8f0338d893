import { describe, expect, it } from "vitest";
import type { Pose } from "../../wire/protocol";
import vectors from "./matching.vectors.json";
import {
  iterate,
  leastKnown,
  lineEquations,
  nearestPairs,
  type PointScan,
  residuals,
  type SurfaceScan,
  scoreField,
  scoresInWindow,
  searchWindow,
  trimmed,
  withNormals,
} from "./model";
import { leastEigen, type Symmetric, solve } from "./symmetric";

const { settings, scans, first, paths } = vectors;
const GUESS = settings.guess as unknown as Pose;
const FIELD = { ...settings.field, origin: settings.field.origin as unknown as Pose };

function scanOf({ points, is_point, sensor }: (typeof scans)["fixed"]): PointScan {
  return {
    x: Float64Array.from(points, (point) => point[0] ?? 0),
    y: Float64Array.from(points, (point) => point[1] ?? 0),
    isPoint: Uint8Array.from(is_point),
    sensor: sensor as unknown as readonly [number, number],
  };
}
const fixed: SurfaceScan = withNormals(scanOf(scans.fixed), settings.normals);
const moving = scanOf(scans.moving);
const pairs = nearestPairs(moving, GUESS, fixed, settings.gate);
const kept = trimmed(pairs, residuals("point_to_line", moving, GUESS, fixed, pairs), settings.keep);

describe("scan matching, as the textbook has it", () => {
  it("finds the normals", () => {
    expect([...fixed.hasNormal]).toEqual(scans.fixed.has_normal);
    scans.fixed.normals.forEach(([nx, ny], k) => {
      expect(fixed.nx[k]).toBeCloseTo(nx as number, 9);
      expect(fixed.ny[k]).toBeCloseTo(ny as number, 9);
    });
  });

  it("pairs the nearest points, and keeps the smallest residuals", () => {
    expect(pairs).toEqual({ ours: first.ours, theirs: first.theirs });
    expect(kept.ours).toEqual(first.kept);
    expect(kept.ours.length).toBeLessThan(pairs.ours.length);
  });

  it("sets up the equations of the distances to the lines", () => {
    const { h, g } = lineEquations(moving, GUESS, fixed, kept);
    const rows = [
      [h[0], h[1], h[2]],
      [h[1], h[3], h[4]],
      [h[2], h[4], h[5]],
    ];
    rows.flat().forEach((value, i) => {
      expect(value).toBeCloseTo(first.h.flat()[i] as number, 8);
    });
    g.forEach((value, i) => {
      expect(value).toBeCloseTo(first.g[i] as number, 8);
    });
    const { share, direction } = leastKnown(h, moving);
    expect(share).toBeCloseTo(vectors.least_known.share, 8);
    const cosine = direction.reduce((sum, value, i) => sum + value * (vectors.least_known.direction[i] ?? 0), 0);
    expect(Math.abs(cosine)).toBeCloseTo(1, 8);
  });

  it.each(["point_to_point", "point_to_line"] as const)("iterates %s to the same poses", (method) => {
    let pose = GUESS;
    for (const expected of paths[method]) {
      pose = iterate(method, moving, pose, fixed, settings.gate, settings.keep);
      pose.forEach((value, i) => {
        expect(value).toBeCloseTo(expected[i] as number, 7);
      });
    }
  });

  it("scores the poses of a window, and finds the best one", () => {
    const { sigma, fine, reach, turns, cells } = settings;
    const scores = scoreField(FIELD, scanOf(scans.fixed), sigma, fine, reach);
    expect([...scores]).toEqual(vectors.scores);
    const turned: Pose = [GUESS[0], GUESS[1], GUESS[2] + (turns[1] ?? 0)];
    expect([...scoresInWindow(scores, FIELD, moving, turned, [cells, cells, cells, cells])]).toEqual(vectors.window);
    const best = searchWindow(scores, FIELD, moving, GUESS, turns, cells);
    expect(best.score).toBe(vectors.best.score);
    best.pose.forEach((value, i) => {
      expect(value).toBeCloseTo(vectors.best.pose[i] as number, 9);
    });
  });

  it("gives 0 for cells of a window that lie outside the field", () => {
    const scores = scoreField(FIELD, scanOf(scans.fixed), settings.sigma, settings.fine, settings.reach);
    const far = scoresInWindow(scores, FIELD, moving, [40, 40, 0], [2, 2, 2, 2]);
    expect([...far]).toEqual(new Array(25).fill(0));
  });
});

describe("symmetric matrices of three rows", () => {
  const h: Symmetric = [4, 1, 0.5, 3, -0.7, 2];
  const times = ([x, y, t]: readonly number[]): readonly number[] => {
    const [a, b, c] = [x ?? 0, y ?? 0, t ?? 0];
    return [4 * a + b + 0.5 * c, a + 3 * b - 0.7 * c, 0.5 * a - 0.7 * b + 2 * c];
  };

  it("are solved", () => {
    const x = solve(h, [1, 2, 3]) ?? [];
    times(x).forEach((value, i) => {
      expect(value).toBeCloseTo(i + 1, 10);
    });
    expect(solve([1, 0, 0, 0, 0, 1], [1, 1, 1])).toBeNull();
  });

  it("have a least eigenvalue", () => {
    const { value, vector } = leastEigen(h);
    times(vector).forEach((entry, i) => {
      expect(entry).toBeCloseTo(value * (vector[i] ?? 0), 10);
    });
    expect(Math.hypot(...vector)).toBeCloseTo(1, 10);
  });
});
