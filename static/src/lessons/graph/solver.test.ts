import { describe, expect, it } from "vitest";
import type { Pose } from "../../wire/protocol";
import vectors from "./graph.vectors.json";
import { type GraphEdge, gaussNewtonStep, type Kernel, optimise, type Solution } from "./solver";

const START = vectors.poses as unknown as readonly Pose[];
const EDGES = vectors.edges as unknown as readonly GraphEdge[];

function expectAlike(found: Solution, wanted: (typeof vectors.solved)["none"]): void {
  found.poses.forEach((pose, k) => {
    pose.forEach((value, axis) => {
      expect(value).toBeCloseTo(wanted.poses[k]?.[axis] ?? Number.NaN, 4);
    });
  });
  found.residuals.forEach((value, e) => {
    expect(value).toBeCloseTo(wanted.residuals[e] ?? Number.NaN, 3);
  });
  found.weights.forEach((value, e) => {
    expect(value).toBeCloseTo(wanted.weights[e] ?? Number.NaN, 3);
  });
}

describe("the lecture's pose graph", () => {
  it.each(Object.keys(vectors.solved) as Kernel[])("is solved as the library does, kernel %s", (kernel) => {
    expectAlike(optimise(START, EDGES, { kernel, scale: vectors.scale, fixed: [0] }), vectors.solved[kernel]);
  });

  it("gives way where a node is held", () => {
    const { node, pose } = vectors.held;
    const start = START.map((startPose, k) => (k === node ? (pose as unknown as Pose) : startPose));
    const found = optimise(start, EDGES, { kernel: "cauchy", scale: vectors.scale, fixed: [0, node] });
    expectAlike(found, vectors.held);
    expect(found.poses[node]).toEqual(pose);
  });

  it("has no step left at the solution, and none at fixed nodes", () => {
    const { poses, weights } = optimise(START, EDGES, { kernel: "none", scale: 3, fixed: [0] });
    const step = gaussNewtonStep(poses, EDGES, weights, [0]);
    expect(step[0]).toEqual([0, 0, 0]);
    expect(Math.max(...step.flat().map(Math.abs))).toBeLessThan(1e-4);
  });
});
