import { describe, expect, it } from "vitest";
import type { Pose } from "../../wire/protocol";
import { distanceTo } from "../common/world";
import { distanceAt, endPoints, isFree, logLikelihood, MAPPED } from "./field";
import { advance, carry, firstState, INITIAL, type Settings, start, type Walk, wander } from "./kidnap";

const driven = (walk: Walk, scans: number, settings: Settings): Walk => {
  let now = walk;
  for (let i = 0; i < scans; i++) now = advance(now, settings);
  return now;
};
const near = (walk: Walk): number => walk.past.at(-1)?.near ?? 0;

describe("the likelihood field of the floor", () => {
  it("has the distance to the nearest wall, and is greatest at the true pose", () => {
    for (const [x, y] of [
      [2.05, 1.75],
      [6.35, 5.15],
      [9.25, 4.55],
    ] as const)
      expect(distanceAt(x, y)).toBeCloseTo(Math.min(2, distanceTo([x, y], MAPPED)), 5);
    const pose: Pose = [7.2, 1.6, 0.3];
    const points = endPoints(pose, 1);
    const best = logLikelihood(points, pose);
    for (const other of [
      [7.6, 1.6, 0.3],
      [7.2, 1.6, 0.8],
      [2.5, 5.5, 0.3],
    ] as const)
      expect(logLikelihood(points, other)).toBeLessThan(best - 3);
  });
});

describe("the kidnapped robot", () => {
  it("walks on the free floor", () => {
    let pose: Pose = [1.2, 1.7, 0];
    for (let i = 0; i < 300; i++) {
      pose = wander(pose);
      expect(isFree([pose[0], pose[1]], 0.15), `step ${i}`).toBe(true);
    }
  });

  it("is followed, lost, and found again, from several places", () => {
    const followed = driven(start(INITIAL), 14, INITIAL);
    expect(near(followed)).toBeGreaterThan(0.95);
    expect(near(firstState(INITIAL))).toBeLessThan(0.1);
    for (const place of [
      [2.2, 6.2, -1.5],
      [10.8, 2.4, 3],
      [6.2, 4.2, 1],
    ] as const) {
      expect(isFree([place[0], place[1]], 0.25)).toBe(true);
      const found = driven(carry(followed, place), 18, INITIAL);
      expect(near(found), String(place)).toBeGreaterThan(0.9);
      expect(found.past.slice(14).some(({ share }) => share > 0.1)).toBe(true);
    }
  });

  it("is not found without random particles", () => {
    const never = { ...INITIAL, alphaSlow: 0, alphaFast: 0 };
    const followed = driven(start(never), 14, never);
    const lost = driven(carry(followed, [10.8, 2.4, 3]), 18, never);
    expect(near(lost)).toBeLessThan(0.1);
    expect(lost.random).toBe(0);
  });
});
