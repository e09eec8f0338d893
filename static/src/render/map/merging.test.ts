import { expect, test } from "vitest";
import { whyNoMerge } from "./combinedMap";

test("maps that count and maps of different priors are not added", () => {
  const fixed = { model: "fixed_increments", log_odds_prior: 0 };
  expect(whyNoMerge(fixed, fixed)).toBeNull();
  expect(whyNoMerge({ ...fixed, model: "hit_counting" }, fixed)).toMatch(/not sums of log-odds/);
  expect(whyNoMerge(fixed, { ...fixed, model: "moravec_elfes" })).toMatch(/not sums of log-odds/);
  expect(whyNoMerge(fixed, { ...fixed, log_odds_prior: 0.2 })).toMatch(/priors/);
});
