// @vitest-environment happy-dom
import { afterAll, expect, test } from "vitest";
import { logOddsAt } from "../../grid/cellValues";
import { PALETTES, paletteOf } from "../../render/map/palettes";
import type { Brush } from "../../render/picture/brush";
import { type LayerContent, OVERLAYS, paintLayer } from "../../render/picture/overlays";
import { Store } from "../../store/store";
import { decodeFrame } from "../../wire/decodeFrame";
import { decodeText } from "../../wire/decodeText";
import { KINDS } from "../../wire/kinds";
import { registerWaves } from "./waves";
import vectors from "./waves.vectors.json";

const HELLO = JSON.stringify({
  type: "hello",
  protocol: "gridbloom.v3",
  session: "s",
  kind: "waves",
  title: "Waves",
  epoch_id: "e",
  speeds: [0.25, 8],
  parameters: { table: [], values: {} },
  sensor: null,
  log: null,
  tables: {},
});
const buffer = (hex: string): ArrayBuffer =>
  Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16)).buffer;

/** The height of the water that the server's side states, at the start, in metres. */
const height = (x: number): number => 0.5 * Math.sin((2 * Math.PI * x) / 4);

/** A page's store that was sent what the server's session sends. */
function watching(): Store {
  const store = new Store(() => true);
  for (const layer of ["height", "floats"]) store.layers.subscribe(layer);
  store.receive(decodeText(HELLO));
  for (const vector of vectors as readonly { text?: string; hex?: string }[]) {
    if (vector.text !== undefined) store.receive(decodeText(vector.text));
    else store.take(decodeFrame(buffer(vector.hex ?? "")));
  }
  return store;
}

test("a page without the kind is outdated", () => {
  expect(() => decodeText(HELLO)).toThrow('This page knows no session kind "waves".');
});

test("with it registered, both layers are received and painted as defined in the file", () => {
  registerWaves();
  const store = watching();
  expect(store.hello.value?.kind).toBe("waves");
  const map = store.layers.grid("height").map.value;
  if (!map) throw new Error("There is no grid.");
  for (const [row, col] of [
    [0, 0],
    [40, 61],
    [79, 119],
  ] as const) {
    const value = logOddsAt(map.cells.at(row, col), map.geometry);
    expect(value).toBeCloseTo(height(0.25 * (col + 0.5)), 2);
  }
  expect([
    ...paletteOf(map)
      .colours()
      .slice(4 * 254, 4 * 255),
  ]).toEqual([254, 254, 255, 255]);

  const floats = store.layers.content("floats").value as LayerContent;
  expect(floats.columns.map((column) => column.length)).toEqual([15, 15, 15]);
  const discs: number[][] = [];
  const ctx = { beginPath() {}, fill() {}, arc: (...given: number[]) => discs.push(given) };
  const brush = { ctx, view: { x: 0, y: 0, scale: 0.1 }, size: { width: 200, height: 100 }, colours: {} };
  paintLayer(brush as unknown as Brush, floats);
  // Ten pixels to the metre around the middle (100, 50), y upwards; eight pixels higher for a metre of height.
  expect(discs[0]?.[0]).toBeCloseTo(110);
  expect(discs[0]?.[1]).toBeCloseTo(50 - 100 - 8 * height(1));
});

afterAll(() => {
  delete KINDS.waves;
  delete PALETTES.height;
  delete OVERLAYS.floats;
});
