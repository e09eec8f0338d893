// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { Cells } from "../../../render/map/cells";
import type { MapPicture } from "../../../render/map/mapPicture";
import { type Pose, TILE } from "../../../wire/protocol";
import { bitsOfBytes, MapWatch, Samples } from "./LabPlots";

const RANGE = { low: -5, high: 5 };

/** The map's cells as int8 of a tile: those of log-odds ±5 are ±127, those that were never observed −128. */
const tile = (...first: number[]): Uint8Array =>
  new Uint8Array(Int8Array.from({ length: TILE * TILE }, (_, k) => first[k] ?? -128).buffer);

function mapOf(cells: Cells): MapPicture {
  const geometry = { resolution: 0.1, rows: 2 * TILE, cols: TILE, origin: [0, 0, 0], epoch: 1, ...RANGE };
  return { cells, style: "belief", geometry: geometry as unknown as MapPicture["geometry"] };
}

/** H(p) of a cell with these log-odds, bit. */
function bits(logOdds: number): number {
  const p = Math.exp(logOdds) / (1 + Math.exp(logOdds));
  return -p * Math.log2(p) - (1 - p) * Math.log2(1 - p);
}

test("a cell of even odds has one bit, one that was never observed none", () => {
  const all = bitsOfBytes(RANGE);
  expect(all[0]).toBe(0);
  expect(all[128]).toBeCloseTo(1, 12);
  expect(all[255]).toBeCloseTo(bits(5), 12);
});

test("entropy and changed cells follow the tiles that are set", () => {
  const cells = new Cells();
  cells.setTile(0, 0, tile(127, -127, 0));
  const watch = new MapWatch(mapOf(cells));
  expect(watch.look().changed).toBe(0);
  expect(watch.look().bits).toBeCloseTo(2 * bits(5) + 1, 9);
  cells.setTile(0, 0, tile(-127, -127, 127)); // occupied to free, undecided to occupied
  cells.setTile(0, 1, tile(127));
  expect(watch.look()).toEqual({ bits: expect.closeTo(4 * bits(5), 9), changed: 3 });
  expect(watch.look().changed).toBe(0);
  watch.stop();
  cells.setTile(0, 0, tile(0));
  expect(watch.look().changed).toBe(0);
});

test("samples have the error of the belief and the speed, and begin anew where time goes back", () => {
  const [cells, samples] = [new Cells(), new Samples()];
  const map = mapOf(cells);
  const at = (stamp: number, pose: Pose, believed?: Pose) =>
    samples.take({ stamp, pose, ...(believed && { believed_pose: believed }) }, map);
  expect(at(1, [0, 0, 0])).toBe(true);
  expect(at(1, [0, 0, 0])).toBe(false);
  cells.setTile(0, 0, tile(127, 127));
  at(1.5, [0.3, 0.4, 0], [0.3, 0.1, 0]);
  expect(samples.times).toEqual([1, 1.5]);
  const [entropy, changed, error, speed] = samples.columns;
  expect(entropy[1]).toBeCloseTo(2 * bits(5), 9);
  expect(changed).toEqual([null, 2]);
  expect(error).toEqual([0, expect.closeTo(0.3, 12)]);
  expect(speed).toEqual([null, 1]);
  cells.setTile(0, 1, tile(127)); // a tile that comes after its frame
  expect(at(1.5, [0.3, 0.4, 0])).toBe(true);
  expect([changed[1], entropy[1]]).toEqual([3, expect.closeTo(3 * bits(5), 9)]);
  at(0.2, [5, 5, 0]);
  expect([samples.times, speed]).toEqual([[0.2], [null]]);
});

test("the oldest samples go", () => {
  const samples = new Samples();
  const map = mapOf(new Cells());
  for (let k = 0; k <= 3000; k++) samples.take({ stamp: k, pose: [k, 0, 0] }, map);
  expect([samples.times.length, samples.times[0], samples.columns[3][0]]).toEqual([2501, 500, 1]);
});
