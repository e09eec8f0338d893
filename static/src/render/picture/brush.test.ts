import { expect, test } from "vitest";
import type { Point } from "../../wire/protocol";
import { type Brush, paintPath } from "./brush";

test("a path is painted to its end where the frame counts more poses than it has", () => {
  const alphas: number[] = [];
  const ctx = {
    globalAlpha: 1,
    beginPath: () => undefined,
    lineTo: () => undefined,
    stroke: () => alphas.push(ctx.globalAlpha),
  };
  const brush = { ctx, colours: { trail: "trail" }, size: { width: 8, height: 8 }, view: { x: 0, y: 0, scale: 1 } };
  const poses: Point[] = [
    [0, 0],
    [2, 0],
  ];
  paintPath(brush as unknown as Brush, poses, 5);
  expect(alphas).toEqual([0.25, 0.8]);
});
