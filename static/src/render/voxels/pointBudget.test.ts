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
    const count = drawAll(budget, now);
    drawn.push(count);
    now += Math.max(16, (count / 1e6) * msPerMillion);
  }
  return { drawn, now };
}

const drawAll = (budget: PointBudget, now: number): number =>
  CLOUDS.reduce((sum, cloud) => sum + budget.take(cloud, now).count, 0);

/** The first and the next number of the points of the first cloud that a frame draws. */
function span(budget: PointBudget, now: number): [number, number] {
  const [{ first, count }] = CLOUDS.map((cloud) => budget.take(cloud, now)) as [{ first: number; count: number }];
  return [first, first + count];
}

/** Frames from the moment that the camera rests; the picture has all points after the last of them. */
function rest(budget: PointBudget, now: number): [number, number][] {
  const spans: [number, number][] = [];
  for (let n = 0; n === 0 || (budget.lacks && n < 1000); n++) spans.push(span(budget, now + 50 * n));
  return spans;
}

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

test("while the camera rests, frames add the next points until all are in the picture", () => {
  const budget = new PointBudget();
  const { now } = orbit(budget, 200, 20);
  expect(budget.adds(now + 100)).toBe(false);
  expect(drawAll(budget, now + 100)).toBeLessThan(ALL / 4);
  const spans = rest(budget, now + 1000);
  const [[begin]] = spans as [[number, number]];
  expect(begin).toBeGreaterThan(0); // it goes on with the picture of the last frame before
  expect(spans.slice(1).map(([first]) => first)).toEqual(spans.slice(0, -1).map(([, end]) => end));
  expect(spans.at(-1)?.[1]).toBe(CLOUDS[0]);
  for (const [first, end] of spans) expect((5 * (end - first) * 200) / 1e6).toBeLessThan(300);
  expect(drawAll(budget, now + 60_000)).toBe(0);
  expect(budget.adds(now + 60_000)).toBe(true);
});

test("the picture begins again where the camera moves, a message comes or something else is drawn", () => {
  const budget = new PointBudget();
  const { now } = orbit(budget, 200, 20);
  let later = now;
  const changes = [
    () => budget.moved(),
    () => budget.hold(true),
    () => budget.hold(false),
    () => budget.changed(),
    () => budget.note(36, later),
  ];
  for (const change of changes) {
    later += 10_000;
    drawAll(budget, later - 2000);
    drawAll(budget, later - 1000);
    drawAll(budget, later);
    change();
    expect(span(budget, later + 50)[0]).toBe(0);
    expect(budget.adds(later + 50)).toBe(false);
  }
});

test("a quick browser draws all of them again in each frame at rest", () => {
  const budget = new PointBudget();
  const { now } = orbit(budget, 5, 60);
  for (const later of [1000, 2000]) {
    expect(drawAll(budget, now + later)).toBe(ALL);
    expect(budget.adds(now + later)).toBe(false);
  }
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
  expect(rest(budget, now + 5000).at(-1)?.[1]).toBe(CLOUDS[0]);
});

test("each cloud has its share, also a small one", () => {
  const budget = new PointBudget();
  budget.take(4_000_000, -1000);
  budget.take(1000, -1000);
  budget.moved();
  expect(budget.take(4_000_000, 0).count / 4_000_000).toBeCloseTo(budget.take(1000, 0).count / 1000, 2);
});

test("a pause between two movements does not lower the number", () => {
  const budget = new PointBudget();
  const { drawn, now } = orbit(budget, 100, 30);
  drawAll(budget, now + 1000); // as viser's client does each second
  const { drawn: later } = orbit(budget, 100, 1, now + 60_000);
  expect(later[0]).toBeGreaterThan(0.8 * (drawn.at(-1) ?? 0));
});
