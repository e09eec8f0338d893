import { effect } from "@preact/signals";
import { beforeEach, expect, test } from "vitest";
import { decodeFrame, type TilesFrame } from "../wire/decodeFrame";
import type { Command, Geometry, LayerInfo } from "../wire/protocol";
import vectors from "../wire/protocol.vectors.json";
import { Layers, MAP } from "./layers";

const grid = (id: number, name: string, style = "belief"): LayerInfo => {
  return { id, name, kind: "grid", title: name, style, columns: [] };
};
const points = (id: number, name: string): LayerInfo => {
  return { id, name, kind: "points", title: name, style: "dots", columns: ["x", "y"] };
};
const geometry = (layer: number, epoch: number): Geometry => {
  const size = { resolution: 0.05, rows: 64, cols: 64, origin: [0, 0, 0], low: 0, high: 1, tile: 64 } as const;
  return { type: "geometry", layer, epoch, ...size };
};
const zstd = (() => {
  const { hex } = vectors.frames[1] as { hex: string };
  const bytes = Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16));
  return ((decodeFrame(bytes.buffer) as TilesFrame).tiles[0] as { data: Uint8Array }).data;
})();
const tiles = (layer: number, epoch: number, revision: number): TilesFrame => {
  return { kind: "tiles", layer, epoch, seq: 1, complete: true, tiles: [{ tx: 0, ty: 0, revision, data: zstd }] };
};
const table = (layer: number, xs: number[]) => {
  const columns = [new Float32Array(xs), new Float32Array(xs)];
  return { kind: "table", layer, epoch: 1, seq: 1, complete: true, columns } as const;
};

let sent: Command[];
let layers: Layers;
beforeEach(() => {
  sent = [];
  layers = new Layers((command) => sent.push(command));
});

test("a layer is subscribed to once while it has any number of subscribers", () => {
  const first = layers.subscribe("particles");
  const second = layers.subscribe("particles");
  expect(sent).toEqual([{ type: "subscribe", layers: [MAP, "particles"] }]);
  first();
  first(); // twice is once
  expect(sent).toHaveLength(1);
  second();
  expect(sent.slice(1)).toEqual([{ type: "subscribe", layers: [MAP] }]);
});

test("a frame goes to the layer of its id, and is dropped without one", () => {
  layers.setLayers([grid(1, MAP), grid(2, "costs", "costs"), points(3, "particles")]);
  for (const name of ["costs", "particles"]) layers.subscribe(name);
  layers.begin(geometry(2, 7));
  layers.take(tiles(2, 7, 1));
  layers.take(tiles(9, 7, 1));
  layers.take(table(3, [1, 2]));
  expect(layers.grid(MAP).map.value).toBeNull();
  expect(layers.grid("costs").map.value?.style).toBe("costs");
  expect(layers.content("particles").value).toMatchObject({ kind: "points", style: "dots", names: ["x", "y"] });
  expect(layers.contents.value).toHaveLength(1);
});

test("a new epoch of one grid leaves the others alone", () => {
  layers.setLayers([grid(1, MAP), grid(2, "costs")]);
  layers.subscribe("costs");
  for (const layer of [1, 2]) {
    layers.begin(geometry(layer, layer));
    layers.take(tiles(layer, layer, 5));
  }
  let changes = 0;
  effect(() => {
    void [layers.grid(MAP).map.value, layers.grid(MAP).version.value];
    changes++;
  });
  layers.begin(geometry(2, 3));
  layers.take(tiles(2, 3, 6));
  expect(layers.grid("costs").map.value?.geometry.epoch).toBe(3);
  expect(changes).toBe(1);
});

test("a new connection resumes each complete grid and subscribes again", () => {
  expect(layers.opening(undefined)).toEqual([]);
  layers.setLayers([grid(1, MAP), grid(2, "costs")]);
  expect(layers.opening("e")).toEqual([]);
  layers.subscribe("costs");
  for (const layer of [1, 2]) {
    layers.begin(geometry(layer, layer));
    layers.take(tiles(layer, layer, 5));
  }
  expect(layers.opening("e")).toEqual([
    { type: "resume", epoch_id: "e", layer: MAP, epoch: 1, revision: 5 },
    { type: "resume", epoch_id: "e", layer: "costs", epoch: 2, revision: 5 },
    { type: "subscribe", layers: [MAP, "costs"] },
  ]);
  layers.forget();
  expect(layers.opening("e")).toEqual([{ type: "subscribe", layers: [MAP, "costs"] }]);
});

test("a layer without subscribers is cleared, and its late frames are dropped", () => {
  layers.setLayers([grid(1, MAP), grid(2, "costs"), points(3, "particles")]);
  const stops = ["costs", "particles"].map((name) => layers.subscribe(name));
  layers.begin(geometry(2, 7));
  layers.take(tiles(2, 7, 1));
  layers.take(table(3, [1]));
  for (const stop of stops) stop();
  layers.take(tiles(2, 7, 2));
  layers.take(table(3, [2]));
  expect([layers.grid("costs").map.value, layers.content("particles").value]).toEqual([null, null]);
  expect(layers.opening("e")).toEqual([]);
  // Wanted again, it begins again under the same epoch.
  layers.subscribe("costs");
  layers.begin(geometry(2, 7));
  layers.take(tiles(2, 7, 3));
  expect(layers.grid("costs").map.value?.geometry.epoch).toBe(7);
});

test("points of a removed layer are not shown", () => {
  layers.setLayers([grid(1, MAP), points(3, "particles")]);
  layers.subscribe("particles");
  layers.take(table(3, [1]));
  layers.setLayers([grid(1, MAP), points(4, "particles")]); // made again
  expect(layers.contents.value).toEqual([]);
  layers.take(table(3, [2])); // of the older one
  expect(layers.contents.value).toEqual([]);
  layers.take(table(4, [3]));
  expect(layers.contents.value).toHaveLength(1);
  layers.setLayers([grid(1, MAP)]);
  expect(layers.contents.value).toEqual([]);
});
