// @vitest-environment happy-dom
import { expect, test } from "vitest";
import type { LayerContent } from "../../render/picture/overlays";
import type { TriedLoop } from "../../wire/http";
import { edgeAt, loopAt, residualLabel, whyNone } from "./poseGraph";

const graph: LayerContent = {
  kind: "graph",
  style: "pose_graph",
  names: ["x", "y", "yaw", "scan"],
  columns: [
    new Float32Array([0, 10, 10]),
    new Float32Array([0, 0, 5]),
    new Float32Array(3),
    new Float32Array([0, 1, 2]),
  ],
  edges: new Uint32Array([0, 1, 1, 2, 0, 2]),
  values: new Float32Array([Number.NaN, Number.NaN, 3]),
};

test("the nearest loop within ten pixels is found, never an edge of odometry", () => {
  expect(loopAt(graph, [4, 2.1], 0.05)).toBe(2);
  expect(loopAt(graph, [4, 0], 0.05)).toBeNull();
  expect(loopAt(graph, [10, 5.3], 0.05)).toBe(2);
  expect(loopAt(graph, [11, 6], 0.05)).toBeNull();
  expect(loopAt(null, [0, 0], 1)).toBeNull();
  expect(edgeAt(graph, [9.9, 3], 0.05)).toBe(1);
  expect(edgeAt(graph, [4, 2.1], 0.05)).toBe(2);
  expect(edgeAt(graph, [9.7, 1], 0.05)).toBeNull();
});

const tried = (accepted: boolean): TriedLoop => ({
  candidate: 0,
  scans: [1, 9],
  away_m: 1,
  score: 0.5,
  inliers: 0.4,
  accepted,
  reason: accepted ? "" : "only 40 % of the points are on walls",
});

test("why no loop closed depends on the visits and on what was tried", () => {
  expect(whyNone({ visits: [], candidates: [] })).toContain("never");
  expect(whyNone({ visits: [[0, 9]], candidates: [] })).toContain("only once");
  expect(
    whyNone({
      visits: [
        [0, 9],
        [80, 90],
      ],
      candidates: [],
    }),
  ).toContain("twice, but no loop was tried");
  expect(
    whyNone({
      visits: [
        [0, 9],
        [80, 90],
      ],
      candidates: [tried(false)],
    }),
  ).toContain("1 loop was tried");
  expect(
    whyNone({
      visits: [
        [0, 9],
        [80, 90],
      ],
      candidates: [tried(false), tried(true)],
    }),
  ).toContain("1 loop closed");
});

test("residuals have words", () => {
  expect([0, 1.9, 2, 4.9, 5, 90].map(residualLabel)).toEqual([
    "fits",
    "fits",
    "strained",
    "strained",
    "contradicts",
    "contradicts",
  ]);
});
