import { expect, test } from "vitest";
import { fitted, framed, MAX_SCALE, MIN_SCALE, panned, toScreen, toWorld, zoomedAt } from "./view";

const size = { width: 640, height: 480 };
const view = { x: 3.5, y: -2, scale: 0.025 };

test("screen and world are each other's inverse, and y points up in the world", () => {
  for (const [px, py] of [
    [0, 0],
    [640, 480],
    [17.5, 333],
  ] as const) {
    const [x, y] = toWorld(view, size, px, py);
    const [qx, qy] = toScreen(view, size, x, y);
    expect(qx).toBeCloseTo(px, 9);
    expect(qy).toBeCloseTo(py, 9);
  }
  expect(toScreen(view, size, 3.5, -2)).toEqual([320, 240]);
  expect(toScreen(view, size, 3.5, -1)[1]).toBeCloseTo(200, 9);
});

test("the point under the pointer stays under the pointer", () => {
  const at = toWorld(view, size, 100, 50);
  const moved = panned(view, 30, -12);
  const [px, py] = toScreen(moved, size, at[0], at[1]);
  expect(px).toBeCloseTo(130, 9);
  expect(py).toBeCloseTo(38, 9);
  const zoomed = zoomedAt(view, size, 100, 50, 1.7);
  const [zx, zy] = toWorld(zoomed, size, 100, 50);
  expect(zx).toBeCloseTo(at[0], 9);
  expect(zy).toBeCloseTo(at[1], 9);
  expect(zoomed.scale).toBeCloseTo(view.scale / 1.7, 12);
});

test("zoom ends somewhere on both sides", () => {
  expect(zoomedAt(view, size, 0, 0, 1e9).scale).toBe(MIN_SCALE);
  expect(zoomedAt(view, size, 0, 0, 1e-9).scale).toBe(MAX_SCALE);
});

test("fitting shows the whole box, touching two sides of the margin", () => {
  const box = [-4, 2, 16, 6] as const;
  const fit = fitted(box, size, 20);
  const [left, bottom] = toScreen(fit, size, box[0], box[1]);
  const [right, top] = toScreen(fit, size, box[2], box[3]);
  expect(left).toBeCloseTo(20, 9);
  expect(right).toBeCloseTo(620, 9);
  expect(top).toBeGreaterThanOrEqual(20);
  expect(bottom).toBeLessThanOrEqual(460);
});

test("a small picture gives less of its height to the margin", () => {
  const box = [0, 0, 20, 14] as const;
  const share = (height: number): number => 14 / fitted(box, { width: 2 * height, height }).scale / height;
  expect(share(160)).toBeGreaterThan(0.9);
  expect(share(160)).toBeLessThan(1);
  expect(800 - 800 * share(800)).toBeCloseTo(32, 9);
});

test("a view that was shared shows all that was seen on a picture of any size, and the same on one of its own", () => {
  const shared = { x: 3, y: -2, scale: 0.02, width: 800, height: 600 };
  expect(framed(shared, { width: 800, height: 600 })).toEqual({ x: 3, y: -2, scale: 0.02 });
  for (const size of [
    { width: 390, height: 500 },
    { width: 1600, height: 300 },
  ]) {
    const { scale } = framed(shared, size);
    expect(size.width * scale).toBeGreaterThanOrEqual(800 * 0.02 - 1e-9);
    expect(size.height * scale).toBeGreaterThanOrEqual(600 * 0.02 - 1e-9);
  }
});
