import { expect, test } from "vitest";
import { PointBudget } from "./pointBudget";

const CLOUDS = [1_000_000, 1_000_000, 1_000_000, 1_000_000, 1_000_000];
const ALL = 5_000_000;

/** A browser that takes a time for each million points, with the camera moving in each of so many frames. */
function orbit(budget: PointBudget, msPerMillion: number, frames: number, start = 0) {
  const drawn: number[] = [];
  let now = start;
  for (let n = 0; n < frames; n++) {
    budget.moved();
    const count = CLOUDS.reduce((sum, cloud) => sum + budget.take(cloud, now), 0);
    drawn.push(count);
    now += Math.max(16, (count / 1e6) * msPerMillion);
  }
  return { drawn, now };
}

const drawAll = (budget: PointBudget, now: number): number =>
  CLOUDS.reduce((sum, cloud) => sum + budget.take(cloud, now), 0);

test("while the camera moves, a slow browser soon draws as many points as take 50 ms", () => {
  const budget = new PointBudget();
  drawAll(budget, -1000);
  const { drawn } = orbit(budget, 200, 40);
  expect(drawn[0]).toBeLessThan(ALL / 4);
  for (const count of drawn.slice(-10)) expect((count / 1e6) * 200).toBeCloseTo(50, -1);
});

test("a quick browser comes to draw all of them, and no more is asked for than there are", () => {
  const budget = new PointBudget();
  const { drawn, now } = orbit(budget, 5, 60);
  expect(drawn.at(-1)).toBe(ALL);
  const { drawn: slower } = orbit(budget, 400, 8, now);
  expect(slower.at(-1)).toBeLessThan(ALL / 10);
});

test("once the camera rests, all are drawn", () => {
  const budget = new PointBudget();
  const { now } = orbit(budget, 100, 20);
  expect(drawAll(budget, now + 100)).toBeLessThan(ALL);
  expect(drawAll(budget, now + 1000)).toBe(ALL);
});

test("where all take seconds, as many as take a second are drawn at rest", () => {
  const budget = new PointBudget();
  const { now } = orbit(budget, 2000, 20);
  const drawn = drawAll(budget, now + 1000);
  expect((drawn / 1e6) * 2000).toBeGreaterThan(500);
  expect((drawn / 1e6) * 2000).toBeLessThan(1500);
});

test("a frame that takes longer than the rest is no rest", () => {
  const budget = new PointBudget();
  const { drawn, now } = orbit(budget, 200, 10);
  budget.moved();
  expect(drawAll(budget, now + 800)).toBeLessThan(1.3 * (drawn.at(-1) ?? 0));
});

test("as long as the camera is held it does not rest", () => {
  const budget = new PointBudget();
  const { now } = orbit(budget, 100, 20);
  budget.hold(true);
  for (const later of [1000, 2000, 3000]) expect(drawAll(budget, now + later)).toBeLessThan(ALL);
  budget.hold(false);
  drawAll(budget, now + 4000); // it may have moved until then
  expect(drawAll(budget, now + 5000)).toBe(ALL);
});

test("each cloud has its share, also a small one", () => {
  const budget = new PointBudget();
  budget.take(4_000_000, -1000);
  budget.take(1000, -1000);
  budget.moved();
  expect(budget.take(4_000_000, 0) / 4_000_000).toBeCloseTo(budget.take(1000, 0) / 1000, 2);
});

test("a pause between two movements does not lower the number", () => {
  const budget = new PointBudget();
  const { drawn, now } = orbit(budget, 100, 30);
  drawAll(budget, now + 1000); // as viser's client does each second
  const { drawn: later } = orbit(budget, 100, 1, now + 60_000);
  expect(later[0]).toBeGreaterThan(0.8 * (drawn.at(-1) ?? 0));
});
