// @vitest-environment happy-dom
import { afterEach, expect, test, vi } from "vitest";
import type { Brush } from "./brush";
import { columnOf, type LayerContent, OVERLAYS, paintLayer, shadesOf } from "./overlays";
import { SHADES } from "./pictureColours";

/** A brush whose strokes are noted: calls of the canvas by name with their arguments. */
function noted(): { brush: Brush; calls: [string, ...unknown[]][] } {
  const calls: [string, ...unknown[]][] = [];
  const target: Record<string, unknown> = {};
  const ctx = new Proxy(target, {
    get: (_, name: string) => target[name] ?? ((...given: unknown[]) => void calls.push([name, ...given])),
    set: (_, name: string, value) => {
      calls.push([`${name} =`, value]);
      target[name] = value;
      return true;
    },
  });
  const colours = { robot: "robot", trail: "trail", shades: Array.from({ length: SHADES }, (_, i) => `shade ${i}`) };
  const view = { x: 0, y: 0, scale: 0.1 };
  return { brush: { ctx, size: { width: 200, height: 100 }, view, colours } as unknown as Brush, calls };
}

const content = (kind: LayerContent["kind"], columns: Record<string, number[]>, more = {}): LayerContent => ({
  kind,
  style: "any",
  names: Object.keys(columns),
  columns: Object.values(columns).map((column) => new Float32Array(column)),
  edges: null,
  values: null,
  ...more,
});
const named = (calls: [string, ...unknown[]][], name: string) =>
  calls.filter(([method]) => method === name).map(([, ...given]) => given);

afterEach(() => {
  for (const style of Object.keys(OVERLAYS)) delete OVERLAYS[style];
});

test("points are dots at their positions; points outside the picture or without a position are not painted", () => {
  const { brush, calls } = noted();
  paintLayer(brush, content("points", { x: [0, 1, 100, Number.NaN], y: [0, 2, 0, 0] }));
  // Ten pixels to the metre around the middle (100, 50), y upwards; dots of 3 pixels.
  expect(named(calls, "fillRect")).toEqual([
    [98.5, 48.5, 3, 3],
    [108.5, 28.5, 3, 3],
  ]);
  expect(named(calls, "fillStyle =")).toEqual([["robot"]]);
});

test("points with a value are coloured from the least to the greatest, those with a yaw have arrows", () => {
  const { brush, calls } = noted();
  paintLayer(
    brush,
    content("points", { x: [0, 0, 1], y: [0, 0, 0], value: [0.1, 0.3, 0.1], yaw: [0, Math.PI / 2, 0] }),
  );
  expect(named(calls, "fillStyle =")).toEqual([["shade 0"], [`shade ${SHADES - 1}`]]);
  const ends = named(calls, "lineTo").map(([x, y]) => [Math.round(Number(x)), Math.round(Number(y))]);
  expect(ends).toEqual([
    [109, 50],
    [119, 50],
    [100, 41],
  ]);
});

test("values are shaded evenly, and one value has one shade", () => {
  expect([...shadesOf(new Float32Array([0, 0.5, 1]))]).toEqual([0, 8, 15]);
  expect([...shadesOf(new Float32Array([2, 2]))]).toEqual([0, 0]);
  expect([...shadesOf(new Float32Array([Number.NaN, 1, 3]))]).toEqual([0, 0, 15]);
  expect(shadesOf(new Float32Array())).toHaveLength(0);
});

test("a path is a line with a gap where a point has no position", () => {
  const { brush, calls } = noted();
  paintLayer(brush, content("path", { x: [0, 1, Number.NaN, 2, 3], y: [0, 0, 0, 0, 0] }));
  expect(named(calls, "moveTo").map(([x]) => x)).toEqual([100, 120]);
  expect(named(calls, "lineTo").map(([x]) => x)).toEqual([110, 130]);
});

test("a graph is its edges, coloured by their values, and its nodes", () => {
  const { brush, calls } = noted();
  const edges = { edges: new Uint32Array([0, 1, 1, 2]), values: new Float32Array([0, 1]) };
  paintLayer(brush, content("graph", { x: [0, 1, 2], y: [0, 0, 0] }, edges));
  expect(named(calls, "moveTo").map(([x]) => x)).toEqual([100, 110]);
  expect(named(calls, "lineTo").map(([x]) => x)).toEqual([110, 120]);
  expect(named(calls, "strokeStyle =").slice(0, 2)).toEqual([["shade 0"], [`shade ${SHADES - 1}`]]);
  expect(named(calls, "fillRect")).toHaveLength(3);
});

test("a registered style paints its layers", () => {
  const { brush, calls } = noted();
  const paint = vi.fn();
  OVERLAYS.stars = paint;
  const stars = { ...content("points", { x: [0], y: [0], size: [4] }), style: "stars" };
  paintLayer(brush, stars);
  expect(paint).toHaveBeenCalledWith(brush, stars);
  expect(calls).toEqual([]);
  expect(columnOf(stars, "size")?.[0]).toBe(4);
  expect(columnOf(stars, "yaw")).toBeUndefined();
});

test("a layer without positions paints nothing", () => {
  for (const kind of ["points", "path", "graph"] as const) {
    const { brush, calls } = noted();
    paintLayer(brush, content(kind, { u: [1] }));
    expect(calls).toEqual([]);
  }
});
