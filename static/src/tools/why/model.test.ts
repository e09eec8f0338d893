import { describe, expect, it } from "vitest";
import type { Contribution, WhyMessage } from "../../wire/protocol";
import { equation, logOddsCurve, sentence, stateOf, updateOf } from "./model";
import { untilFor } from "./Why";

const LOW = -2;
const HIGH = 3.5;

function whyOf(hits: readonly boolean[], more: Partial<WhyMessage> = {}): WhyMessage {
  let log_odds = more.prior ?? 0;
  const contributions = hits.map((hit, i): Contribution => {
    const increment = hit ? 0.85 : -0.4;
    log_odds = Math.min(HIGH, Math.max(LOW, log_odds + increment));
    const seen = { scan: 10 * i + 4, stamp: i, beam: 90, pose: [0, 0, 0], bearing: 0.1, range: 3.21 } as const;
    return { ...seen, n: i + 1, hit, increment, log_odds };
  });
  return {
    type: "why",
    row: 3,
    col: 4,
    epoch: 1,
    index: 500,
    log_odds,
    prior: 0,
    log_odds_min: LOW,
    log_odds_max: HIGH,
    per_scan: false,
    total: hits.length,
    hits: hits.filter(Boolean).length,
    outweighed: 0,
    first_scan: contributions[0]?.scan ?? null,
    curve: contributions.map(({ n, log_odds }) => [n, log_odds]),
    contributions,
    layer: "map",
    ...more,
  };
}

const last = (why: WhyMessage): Contribution | null => why.contributions.at(-1) ?? null;

describe("the sentence", () => {
  it("contains the state, the counts and the last beam", () => {
    const why = whyOf([true, false, true, true]);
    expect(sentence(why, last(why), 0)).toBe(
      "Occupied, p 0.90: 3 beams ended here, 1 passed through; the last, from scan 35 at 3.2 m, ended here.",
    );
  });

  it("speaks of a window, of one beam, and of a beam without return", () => {
    const why = whyOf([true, false, false, false, false, false, false]);
    const silent = { ...(last(why) as Contribution), range: null };
    expect(sentence(why, silent, 0.2)).toBe(
      "Free, p 0.18: 1 beam ended at or near it, 6 passed through; the last, from scan 65, passed through without return.",
    );
  });

  it("says how many misses count for nothing, and why the last one does", () => {
    const why = whyOf([true, false, false], { outweighed: 1 });
    const after = { ...(last(why) as Contribution), increment: 0, outweighed: true };
    expect(sentence(why, after, 0)).toContain(
      "1 beam ended here, 2 passed through (1 of them in scans that hit it, where only the hits count); the last, from " +
        "scan 25 at 3.2 m, passed through, but other beams of its scan ended here: it counts for nothing.",
    );
  });

  it("states that a per-scan update counts scans", () => {
    const why = whyOf([true, true, false], { per_scan: true });
    expect(sentence(why, last(why), 0)).toContain("each scan counts once, 2 as a hit, 1 as a miss; the last");
  });

  it("states when no beam updated the cell", () => {
    const why = whyOf([], { prior: -0.3, log_odds: -0.3, index: 1 });
    expect(stateOf(why)).toBe("never observed");
    expect(sentence(why, null, 0)).toBe(
      "Never observed: no beam of the 1 scan in the map updated this cell. It has its prior value, ℓ −0.30.",
    );
  });
});

describe("an update", () => {
  it("goes from the value before to the value after", () => {
    const why = whyOf([false, true]);
    expect(equation(updateOf(why, 1) as never)).toBe("0.00 − 0.40 = −0.40");
    expect(equation(updateOf(why, 2) as never)).toBe("−0.40 + 0.85 = 0.45");
    expect(updateOf(why, 3)).toBeNull();
  });

  it("shows where the clamp cut it", () => {
    const why = whyOf([true, true, true, true, true]);
    expect(equation(updateOf(why, 5) as never)).toBe("3.40 + 0.85 = 4.25 → 3.50");
  });

  it("is null if the update before it is unknown", () => {
    const whole = whyOf([true, true, true, true]);
    const why = { ...whole, contributions: whole.contributions.slice(2) };
    expect(updateOf(why, 3)).toBeNull();
    expect(updateOf(why, 4)?.before).toBeCloseTo(2.55, 12);
  });
});

it("the story begins with the prior", () => {
  expect(logOddsCurve(whyOf([true], { prior: 0 }))).toEqual([
    [0, 0],
    [1, 0.85],
  ]);
});

it("the requested window contains each update and the one before it", () => {
  for (const total of [1, 199, 300, 301, 1234]) {
    for (let n = 1; n <= total; n++) {
      const until = Math.min(untilFor(n, total) ?? total, total);
      expect(until).toBeGreaterThanOrEqual(n);
      if (n > 1) expect(until - 300 + 1).toBeLessThanOrEqual(n - 1);
    }
  }
  expect(untilFor(null, 1000)).toBeUndefined();
});
