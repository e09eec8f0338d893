import { expect, test } from "vitest";
import { logOddsAt } from "../../grid/cellValues";
import { mergedCodes } from "./combinedMap";

const RANGE = { low: -2, high: 3.5 };
const WIDE = { low: -4, high: 6 };
const chance = (logOdds: number): number => 1 / (1 + Math.exp(-logOdds));

test("a cell that one map has not observed keeps the value of the other", () => {
  const codes = mergedCodes(RANGE, RANGE, 0.4);
  expect(codes[0]).toBe(0);
  for (let i = 1; i < 256; i++) {
    expect(codes[i << 8]).toBe(i);
    expect(codes[i]).toBe(i);
  }
});

test("two independent pieces of evidence multiply the odds, the prior's counted once", () => {
  const prior = -0.3;
  const codes = mergedCodes(WIDE, RANGE, prior);
  const odds = (p: number): number => p / (1 - p);
  let inside = 0;
  for (let i = 1; i < 256; i += 3) {
    for (let j = 1; j < 256; j += 3) {
      const oddsProduct = (odds(chance(logOddsAt(i, WIDE))) * odds(chance(logOddsAt(j, RANGE)))) / odds(chance(prior));
      const wanted = Math.log(oddsProduct);
      const shown = logOddsAt(codes[(i << 8) | j] as number, RANGE);
      const half = 0.5 * (5.5 / 254) + 1e-9;
      if (wanted < RANGE.low) expect(shown).toBe(RANGE.low);
      else if (wanted > RANGE.high) expect(shown).toBe(RANGE.high);
      else {
        inside++;
        expect(Math.abs(shown - wanted)).toBeLessThanOrEqual(half);
      }
    }
  }
  expect(inside).toBeGreaterThan(1000);
});
