import { describe, expect, it } from "vitest";
import { allRound, box, castRay, scanFrom } from "./world";

describe("the lecture's world", () => {
  it("measures the distance to the nearest wall", () => {
    const room = box(0, 0, 4, 3);
    expect(castRay(room, 1, 1, 0)).toBeCloseTo(3, 12);
    expect(castRay(room, 1, 1, Math.PI / 2)).toBeCloseTo(2, 12);
    expect(castRay(room, 1, 1, Math.PI / 4)).toBeCloseTo(2 * Math.SQRT2, 12);
    expect(castRay([...room, [2, 0, 2, 2]], 1, 1, 0)).toBeCloseTo(1, 12);
    expect(castRay([[2, 0, 2, 2]], 1, 1, Math.PI)).toBe(Number.POSITIVE_INFINITY);
  });

  it("reports no return beyond the lidar's range", () => {
    const scan = scanFrom(box(0, 0, 4, 3), [1, 1, 0], allRound(4, 2.5));
    expect([...scan.ranges]).toEqual([Number.POSITIVE_INFINITY, 2, 1, 1].map(Math.fround));
  });
});
