/** A pose from pairs of points of which many are wrong. Source: Fischler & Bolles 1981. */

import { seeded } from "../../grid/random";
import type { Pose } from "../../wire/protocol";
import { bestRigidMotion, type Pairs, type PointScan, placed } from "./model";

export interface Agreed {
  readonly pose: Pose;
  /** Of each pair, whether its points lie on one another at the pose. */
  readonly isInlier: readonly boolean[];
}

/** The pose of two pairs drawn at random at which most pairs are nearer than `gate` metres; of `draws` draws. */
export function ransac(moving: PointScan, fixed: PointScan, pairs: Pairs, gate: number, draws: number): Agreed {
  const random = seeded(1);
  const count = pairs.ours.length;
  let best: Agreed = { pose: [0, 0, 0], isInlier: [] };
  let most = -1;
  for (let draw = 0; draw < draws; draw++) {
    const [a, b] = [Math.floor(random() * count), Math.floor(random() * count)];
    if (a === b) continue;
    const pick = (of: readonly number[]): readonly number[] => [of[a] ?? 0, of[b] ?? 0];
    const pose = bestRigidMotion(moving, fixed, { ours: pick(pairs.ours), theirs: pick(pairs.theirs) });
    const at = placed(moving, pose);
    const isInlier = pairs.ours.map((k, i) => {
      const j = pairs.theirs[i] ?? 0;
      const [dx, dy] = [(at.x[k] ?? 0) - (fixed.x[j] ?? 0), (at.y[k] ?? 0) - (fixed.y[j] ?? 0)];
      return Math.hypot(dx, dy) < gate;
    });
    const inliers = isInlier.filter(Boolean).length;
    if (inliers > most) [most, best] = [inliers, { pose, isInlier }];
  }
  return best;
}
