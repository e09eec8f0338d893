import { describe, expect, it } from "vitest";
import { run, saturatedAt } from "../digits/model";
import { foundAgain, walk } from "../localization/state";
import { FIRST_PLACE, GLASS, WALLS, withoutReturn } from "../noreturn/model";
import { byOdometry, errorOf, USUAL } from "../odometry/model";
import { sizeOf } from "../resolution/model";
import { castRay } from "./world";

describe("the numbers that are guessed", () => {
  it("1 − p is 1 / (1 + 3ⁿ), which 24 bits cannot tell from 0 beside 1 once it is below 2⁻²⁵", () => {
    const n = saturatedAt(run({ hits: 60, misses: 60, pHit: 0.75, pMiss: 0.25 }), "p");
    expect(n).toBe(Math.ceil((25 * Math.log(2)) / Math.log(3)));
  });

  it("beams without return are those whose nearest surface is glass or too far", () => {
    const [x, y] = FIRST_PLACE;
    const angles = Array.from({ length: 180 }, (_, k) => -Math.PI + (k * 2 * Math.PI) / 180);
    const lost = angles.filter(
      (angle) => castRay(WALLS, x, y, angle) > 5 || castRay(GLASS, x, y, angle) < castRay(WALLS, x, y, angle),
    );
    expect(withoutReturn(FIRST_PLACE, 5)).toBe(lost.length);
    expect(lost.length).toBeGreaterThan(20);
    expect(lost.length).toBeLessThan(120);
  });

  it("a floor of 12 × 8 m has 240,000 cells of 2 cm, with 4 bytes each", () => {
    expect(sizeOf(0.02).bytes).toBe((12 / 0.02) * (8 / 0.02) * 4);
    expect(Math.round(sizeOf(0.05).bytes / 1000)).toBe(154); // as the question says
  });

  it("twice the heading error is on the axis, and more than the first state's", () => {
    const error = errorOf(byOdometry({ ...USUAL, turn: 2 * USUAL.turn }));
    expect(error).toBeGreaterThan(errorOf(byOdometry(USUAL)));
    expect(error).toBeLessThan(6);
  });

  it("the robot is found again within the axis, and the figure shows that scan", () => {
    const scans = foundAgain();
    expect(scans).toBeGreaterThan(2);
    expect(scans).toBeLessThan(60);
    const { past } = walk.value;
    expect(past.at(-1)?.near).toBeGreaterThan(0.5);
    expect(past.slice(-scans - 1, -1).every(({ near }) => near <= 0.5)).toBe(true);
  });
});
