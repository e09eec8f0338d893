import { beforeEach, describe, expect, test, vi } from "vitest";
import { beamAt, beamToward } from "../grid/beams";
import { decodeFrame, type TilesFrame } from "../wire/decodeFrame";
import type { Command, Frame, Geometry, Hello, ServerMessage } from "../wire/protocol";
import vectors from "../wire/protocol.vectors.json";
import { Outbox } from "./sessionSignals";
import { Store } from "./store";

test("the outbox sends the newest of each kind, once per frame, with all values that were set", () => {
  const sent: Command[] = [];
  const frames: (() => void)[] = [];
  const outbox = new Outbox(
    (command) => sent.push(command),
    (task) => frames.push(task),
  );
  outbox.put({ type: "teleport", x: 1, y: 1 });
  outbox.put({ type: "teleport", x: 2, y: 2 });
  outbox.putValue("parameters", "a", 1);
  outbox.putValue("parameters", "b", 2);
  outbox.putValue("parameters", "a", 3);
  expect(sent).toEqual([]);
  expect(frames.length).toBe(1);
  frames[0]?.();
  expect(sent).toEqual([
    { type: "teleport", x: 2, y: 2 },
    { type: "parameters", values: { a: 3, b: 2 } },
  ]);
  outbox.put({ type: "play" });
  expect(frames.length).toBe(2);
});

const hello = (epoch_id: string): Hello => ({
  type: "hello",
  protocol: "gridbloom.v3",
  session: "s",
  kind: "simulation",
  title: "t",
  epoch_id,
  speeds: [1, 1],
  parameters: { table: [], values: { log_odds_hit: 0.85 } },
  sensor: null,
  log: null,
  tables: {},
});
const LAYERS: ServerMessage = {
  type: "layers",
  layers: [{ id: 1, name: "map", kind: "grid", title: "Map", style: "belief", columns: [] }],
};
const geometry = (epoch: number): Geometry => ({
  type: "geometry",
  layer: 1,
  epoch,
  resolution: 0.05,
  rows: 128,
  cols: 128,
  origin: [0, 0, 0],
  low: -2,
  high: 3.5,
  tile: 64,
});
const zstd = (() => {
  const { hex } = vectors.frames[1] as { hex: string };
  const bytes = Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16));
  return ((decodeFrame(bytes.buffer) as TilesFrame).tiles[0] as { data: Uint8Array }).data;
})();
const tiles = (epoch: number, revision: number, complete: boolean): TilesFrame => ({
  kind: "tiles",
  layer: 1,
  epoch,
  seq: 1,
  complete,
  tiles: [{ tx: 0, ty: 0, revision, data: zstd }],
});
const frame: Frame = {
  type: "frame",
  t: 0,
  playing: true,
  speed: 1,
  index: 1,
  count: 1,
  stamp: 0,
  pose: [3, 3, 0],
  sensor_pose: [3, 3, 1],
  scan_pose: [3, 3, Math.PI / 2],
  ranges: [1, 2, null, 1.5],
  angle_min: -Math.PI,
  angle_increment: Math.PI / 2,
  range_max: 10,
  auto: true,
};

describe("the store", () => {
  let sent: Command[];
  let store: Store;
  beforeEach(() => {
    sent = [];
    const send = (command: Command): boolean => sent.push(command) > 0;
    store = new Store(send, new Outbox(send, (task) => task()));
  });

  test("what is sent at once does not overtake what waits for the next frame", () => {
    const frames: (() => void)[] = [];
    const send = (command: Command): boolean => sent.push(command) > 0;
    const patient = new Store(send, new Outbox(send, (task) => frames.push(task)));
    patient.setParameter("window", 0.3);
    patient.send({ type: "step", scans: 1 });
    for (const task of frames) task();
    expect(sent).toEqual([
      { type: "parameters", values: { window: 0.3 } },
      { type: "step", scans: 1 },
    ]);
  });

  test("only a complete picture is something to resume from", () => {
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 7, false));
    expect(store.opening()).toEqual([]);
    store.take(tiles(1, 5, true));
    expect(store.opening()).toEqual([{ type: "resume", epoch_id: "a", layer: "map", epoch: 1, revision: 7 }]);
    store.receive(geometry(1)); // sent again after a reconnect: the same epoch
    expect(store.opening()).toHaveLength(1);
    store.receive(geometry(2));
    expect(store.opening()).toEqual([]);
  });

  test("the pictures are fitted to the observed cells of a complete map", () => {
    store.receive({ ...hello("a"), kind: "log" });
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 1, false));
    store.fitObserved();
    const grid = store.bounds.value;
    expect(store.observed.value).toBeNull();
    store.take(tiles(1, 2, true));
    store.fitObserved();
    const box = store.map.value?.cells.observedBox();
    expect(box).toBeTruthy();
    const { resolution, origin } = geometry(1);
    const ends = [box?.col0, box?.row0, (box?.col1 ?? 0) + 1, (box?.row1 ?? 0) + 1];
    expect(store.bounds.value).toEqual(ends.map((cell, k) => (origin[k % 2] ?? 0) + (cell ?? 0) * resolution));
    expect(store.bounds.value).not.toEqual(grid);
  });

  test("the old picture stays on show until the new epoch is complete", () => {
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 1, true));
    store.receive(geometry(2));
    expect(store.map.value?.geometry.epoch).toBe(1);
    store.take(tiles(1, 2, true)); // of the older epoch: void
    store.take(tiles(2, 3, false));
    expect(store.map.value?.geometry.epoch).toBe(1);
    store.take(tiles(2, 3, true));
    expect(store.map.value?.geometry.epoch).toBe(2);
    expect(store.map.value?.cells.at(0, 1)).toBe(1);
  });

  test("but not for ever: a slow new epoch shows what it has", () => {
    const clock = vi.spyOn(performance, "now").mockReturnValue(1000);
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 1, true));
    store.receive(geometry(2));
    clock.mockReturnValue(1200);
    store.receive(geometry(3)); // the slider moves on
    clock.mockReturnValue(1300);
    store.take(tiles(3, 3, false));
    expect(store.map.value?.geometry.epoch).toBe(3);
    clock.mockRestore();
  });

  test("a session made again voids what there is, though its epochs count alike", () => {
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 9, true));
    store.receive(hello("b"));
    expect(store.opening()).toEqual([]);
    store.receive(geometry(1));
    store.take(tiles(1, 2, true));
    expect(store.opening()).toEqual([{ type: "resume", epoch_id: "b", layer: "map", epoch: 1, revision: 2 }]);
  });

  test("a question that came too late refuses nothing and is no news", () => {
    store.receive(hello("a"));
    store.setParameter("log_odds_hit", 1.5);
    store.receive({ type: "error", code: "command.epoch", message: "Epoch 1 is over; the map is in epoch 2." });
    expect(store.notice.value).toBeNull();
    expect(store.mapping.values.value.log_odds_hit).toBe(1.5);
    store.receive({ type: "error", code: "config.range", message: "log_odds_hit is out of range." });
    expect(store.notice.value?.kind).toBe("error");
    expect(store.mapping.values.value.log_odds_hit).not.toBe(1.5);
  });

  test("a tile that cannot be read is an error of the protocol", () => {
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    const broken = { ...tiles(1, 1, true), tiles: [{ tx: 0, ty: 0, revision: 1, data: new Uint8Array([1, 2, 3]) }] };
    expect(() => store.take(broken)).toThrow(expect.objectContaining({ code: "tile.data" }));
  });

  test("values that were set without a connection are sent after the reconnect", () => {
    store.receive(hello("a"));
    store.setParameter("log_odds_hit", 2);
    sent.length = 0;
    store.receive(hello("a"));
    expect(sent).toEqual([{ type: "parameters", values: { log_odds_hit: 2 } }]);
  });

  test("changed cells are reported while the map changes, not while a whole picture arrives", () => {
    let changed = 0;
    store.onCellChange = () => void changed++;
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 1, true));
    expect(changed).toBe(0);
    store.take({ ...tiles(1, 2, true), tiles: [{ tx: 1, ty: 0, revision: 2, data: zstd }] });
    expect(changed).toBeGreaterThan(0);
  });

  test("no changed cells are reported for a map recomputed from the same readings, but for new readings after it", () => {
    const changed: number[] = [];
    const more = (tx: number) => ({ ...tiles(1, 2 + tx, true), tiles: [{ tx, ty: 0, revision: 2 + tx, data: zstd }] });
    store.onCellChange = () => void changed.push(1);
    store.receive(hello("a"));
    store.receive(LAYERS);
    store.receive(geometry(1));
    store.take(tiles(1, 1, true));
    const retuned = { type: "parameters", values: { log_odds_hit: 1.5 }, sensor: null } as const;
    store.receive(retuned);
    store.take({ ...more(1), complete: false });
    store.take(more(2));
    expect(changed).toHaveLength(0);
    store.receive(retuned); // nothing new: no map follows
    store.take(more(3));
    expect(changed.length).toBeGreaterThan(0);
  });

  test("the correction of the mount turns the beams in the map, not in the world", () => {
    store.receive(hello("a"));
    store.receive({ ...frame, scan_pose: [1, 2, 0] });
    store.setParameter("mount_x", 0.5);
    store.setParameter("mount_yaw", 0.1);
    expect(store.beliefPose.value).toEqual([1.5, 2, 0.1]);
    expect(store.frame.value?.scan_pose).toEqual([1, 2, 0]);
  });

  test("a mount that is set to upside down mirrors the beams in the map, not in the world", () => {
    store.receive(hello("a"));
    store.receive({ ...frame, angle_min: -1, angle_increment: 0.5 });
    expect(store.beliefFrame.value).toBe(store.frame.value);
    store.setParameter("mount_upside_down", true);
    expect(store.beliefFrame.value).toMatchObject({ angle_min: 1, angle_increment: -0.5 });
    expect(store.frame.value).toMatchObject({ angle_min: -1, angle_increment: 0.5 });
  });

  test("the beam that is looked at is the one towards the pointer, straight ahead without one", () => {
    store.receive(hello("a"));
    store.receive(frame);
    expect(store.inspectedBeam.value).toEqual({ index: 2, bearing: 0, range: null });
    store.pointer.value = [9, 3.2]; // to the right of a sensor that looks up
    expect(store.inspectedBeam.value?.index).toBe(1);
    store.pinned.value = [-9, 3];
    expect(store.inspectedBeam.value?.index).toBe(3);
  });
});

describe("beams", () => {
  test("directions wrap, and there is no beam outside the sensor's field of view", () => {
    const from = [0, 0, 0] as const;
    expect(beamToward(frame, from, [-1, 1e-9])?.index).toBe(0);
    expect(beamToward(frame, from, [-1, -1e-9])?.index).toBe(0);
    const narrow = { ...frame, angle_min: -0.1, angle_increment: 0.1, ranges: [1, 1, 1] };
    expect(beamToward(narrow, from, [1, 0])?.index).toBe(1);
    expect(beamToward(narrow, from, [1, -0.12])?.index).toBe(0);
    expect(beamToward(narrow, from, [-1, 0])).toBeNull();
    const clockwise = { ...frame, angle_min: 0.1, angle_increment: -0.1, ranges: [1, 2, 3] };
    expect(beamToward(clockwise, from, [1, -0.1])?.index).toBe(2);
    expect(beamAt(frame, 17)).toBeNull();
  });
});
