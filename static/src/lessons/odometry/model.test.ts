import { describe, expect, it } from "vitest";
import type { Pose } from "../../wire/protocol";
import { byOdometry, corrected, errorOf, mapAlong, type Noise, otherEnds, TRUTH } from "./model";

const DEGREE = Math.PI / 180;
const NONE: Noise = { way: 0, turn: 0 };
const USUAL: Noise = { way: 0.05, turn: 4 * DEGREE };

/** All poses corrected one after another. */
function byMatching(size: Noise): readonly Pose[] {
  const poses: Pose[] = [TRUTH[0] as Pose];
  while (poses.length < TRUTH.length) poses.push(corrected(poses, size));
  return poses;
}

describe("odometry and its correction", () => {
  it("is the true path without noise", () => {
    expect(errorOf(byOdometry(NONE))).toBeLessThan(1e-9);
    expect(otherEnds(NONE).every(([x]) => Math.abs(x - (TRUTH[TRUTH.length - 1]?.[0] ?? 0)) < 1e-9)).toBe(true);
  });

  it("drifts with the noise, and matching corrects most of it", () => {
    const raw = errorOf(byOdometry(USUAL));
    expect(errorOf(byOdometry({ way: 0.1, turn: 8 * DEGREE }))).toBeGreaterThan(1.3 * raw);
    expect(errorOf(byMatching(USUAL))).toBeLessThan(0.2 * raw);
  });

  it("maps fewer cells as occupied along better poses", () => {
    const walls = (poses: Parameters<typeof mapAlong>[0]): number =>
      mapAlong(poses).logOdds.reduce((sum, value) => sum + (value > 0 ? 1 : 0), 0);
    expect(walls(byMatching(USUAL))).toBeLessThan(walls(byOdometry(USUAL)));
  });
});
