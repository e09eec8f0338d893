/** The pose of a frame in any other one of the same tree, as tf2's lookupTransform gives it. */

import type { FrameEdgeAnswer } from "../../../wire/http";

type Edge = Pick<FrameEdgeAnswer, "parent" | "child" | "offset" | "angles" | "used">;

/** A 3 × 3 rotation, row by row, and a translation, m: p ↦ R p + t. */
interface Transform {
  readonly rotation: readonly number[];
  readonly offset: readonly number[];
}

/** x, y, z, m, and roll, pitch, yaw, rad (REP 103), of a frame in another one; or why there are none. */
export type FramePose =
  | { readonly offset: readonly number[]; readonly angles: readonly number[] }
  | { readonly why: string };

const IDENTITY: Transform = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], offset: [0, 0, 0] };

/** R = Rz(yaw) Ry(pitch) Rx(roll). */
function rotationOf([roll = 0, pitch = 0, yaw = 0]: readonly number[]): readonly number[] {
  const [cr, sr, cp, sp] = [Math.cos(roll), Math.sin(roll), Math.cos(pitch), Math.sin(pitch)];
  const [cy, sy] = [Math.cos(yaw), Math.sin(yaw)];
  return [
    cy * cp,
    cy * sp * sr - sy * cr,
    cy * sp * cr + sy * sr,
    sy * cp,
    sy * sp * sr + cy * cr,
    sy * sp * cr - cy * sr,
    -sp,
    cp * sr,
    cp * cr,
  ];
}

function anglesOf(rotation: readonly number[]): readonly number[] {
  const [r0 = 0, r1 = 0, , r3 = 0, r4 = 0, , r6 = 0, r7 = 0, r8 = 0] = rotation;
  const pitch = Math.asin(Math.min(1, Math.max(-1, -r6)));
  // Straight up or down only the sum or the difference of roll and yaw is known: the roll is taken as 0.
  if (Math.abs(r6) > 1 - 1e-9) return [0, pitch, Math.atan2(-r1, r4)];
  return [Math.atan2(r7, r8), pitch, Math.atan2(r3, r0)];
}

const rotated = (rotation: readonly number[], point: readonly number[]): number[] =>
  [0, 3, 6].map((row) => [0, 1, 2].reduce((sum, k) => sum + (rotation[row + k] ?? 0) * (point[k] ?? 0), 0));

function composed(a: Transform, b: Transform): Transform {
  const columns = [0, 1, 2].map((col) =>
    rotated(
      a.rotation,
      [0, 3, 6].map((row) => b.rotation[row + col] ?? 0),
    ),
  );
  return {
    rotation: [0, 1, 2].flatMap((row) => columns.map((column) => column[row] ?? 0)),
    offset: rotated(a.rotation, b.offset).map((value, k) => value + (a.offset[k] ?? 0)),
  };
}

function inverse({ rotation, offset }: Transform): Transform {
  const transposed = [0, 1, 2].flatMap((row) => [0, 3, 6].map((col) => rotation[row + col] ?? 0));
  return { rotation: transposed, offset: rotated(transposed, offset).map((value) => 0 - value) };
}

/** The names of a frame and of those above it, up to the root; a loop ends where it begins again. */
function pathOf(edgeOf: ReadonlyMap<string, Edge>, name: string): readonly string[] {
  const path: string[] = [];
  for (let at: string | undefined = name; at !== undefined && !path.includes(at); at = edgeOf.get(at)?.parent)
    path.push(at);
  return path;
}

/** The pose of the frame `child` in the frame `parent` at the moment of the edges. */
export function poseInFrame(edges: readonly Edge[], child: string, parent: string): FramePose {
  const edgeOf = new Map(edges.filter(({ used }) => used).map((edge) => [edge.child, edge]));
  const [from, to] = [pathOf(edgeOf, child), pathOf(edgeOf, parent)];
  const common = from.find((name) => to.includes(name));
  if (common === undefined) return { why: `No transforms join ${child} with ${parent}.` };
  const missing: string[] = [];
  const upTo = (path: readonly string[]): Transform =>
    path.slice(0, path.indexOf(common)).reduce((below, name) => {
      const edge = edgeOf.get(name);
      if (!edge?.offset || !edge.angles) missing.push(name);
      return composed({ rotation: rotationOf(edge?.angles ?? []), offset: edge?.offset ?? [0, 0, 0] }, below);
    }, IDENTITY);
  const pose = composed(inverse(upTo(to)), upTo(from));
  if (missing.length > 0) return { why: `No transform of ${missing[0]} has been received yet at this moment.` };
  return { offset: pose.offset, angles: anglesOf(pose.rotation) };
}
