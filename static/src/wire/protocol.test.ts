import { decompress } from "fzstd";
import { describe, expect, test } from "vitest";
import { decodeFrame } from "./decodeFrame";
import { decodeText, OutdatedPageError } from "./decodeText";
import { FIELDS } from "./messages";
import { type Command, encodeCommand, ProtocolError } from "./protocol";
import vectors from "./protocol.vectors.json";

const bytes = (hex: string): Uint8Array<ArrayBuffer> =>
  Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16));

describe("what the server writes is read", () => {
  test.each(vectors.frames.map((frame, i) => [i, frame] as const))("binary frame %i", (_, frame) => {
    const read = decodeFrame(bytes(frame.hex).buffer);
    if (read.kind !== "tiles") throw new Error(read.kind);
    expect([read.layer, read.epoch, read.seq, read.complete]).toEqual([
      frame.layer,
      frame.epoch,
      frame.seq,
      frame.complete,
    ]);
    expect(read.tiles.map(({ tx, ty, revision }) => ({ tx, ty, revision }))).toEqual(
      frame.tiles.map(({ tx, ty, revision }) => ({ tx, ty, revision })),
    );
    for (const [i, tile] of read.tiles.entries()) {
      const cells = decompress(tile.data, new Uint8Array(4096));
      expect(cells).toEqual(bytes(frame.tiles[i]?.cells ?? ""));
    }
  });

  /** Columns as JSON has them: null for NaN. */
  const plain = (columns: readonly Float32Array[]) =>
    columns.map((column) => [...column].map((value) => (Number.isNaN(value) ? null : value)));

  test.each(vectors.tables.map((frame, i) => [i, frame] as const))("table %i", (_, { hex, columns, ...header }) => {
    const read = decodeFrame(bytes(hex).buffer);
    if (read.kind !== "table") throw new Error(read.kind);
    expect(read).toMatchObject({ ...header, complete: true });
    expect(plain(read.columns)).toEqual(columns);
  });

  test.each(vectors.graphs.map((frame, i) => [i, frame] as const))("graph %i", (_, vector) => {
    const { hex, columns, edges, values, ...header } = vector;
    const read = decodeFrame(bytes(hex).buffer);
    if (read.kind !== "graph") throw new Error(read.kind);
    expect(read).toMatchObject({ ...header, complete: true });
    expect(plain(read.columns)).toEqual(columns);
    expect([...read.edges]).toEqual(edges.flat());
    expect([...read.values]).toEqual(values);
  });

  test.each(vectors.changes.map((frame, i) => [i, frame] as const))("changes %i", (_, { hex, tiles, ...header }) => {
    const read = decodeFrame(bytes(hex).buffer);
    if (read.kind !== "changes") throw new Error(read.kind);
    expect(read).toMatchObject({ ...header, complete: true });
    expect(
      read.tiles.map(({ tx, ty, places, values }) => ({
        tx,
        ty,
        places: [...places],
        values: [...new Int8Array(values)],
      })),
    ).toEqual(tiles);
  });

  test.each(vectors.broken.map(({ hex, code }) => [hex.slice(0, 40), hex, code] as const))(
    "refused: %s…",
    (_, hex, code) => {
      let said = "";
      try {
        decodeFrame(bytes(hex).buffer);
      } catch (error) {
        said = error instanceof ProtocolError ? error.code : String(error);
      }
      expect(said).toBe(code);
    },
  );

  test("commands are written as the server reads them", () => {
    for (const text of vectors.commands) {
      expect(JSON.parse(encodeCommand(JSON.parse(text) as Command))).toEqual(JSON.parse(text));
    }
  });
});

describe("each message of the server", () => {
  const messages = vectors.messages.map((text) => [JSON.parse(text).type as string, text] as const);

  test("has a vector", () => {
    expect(new Set(messages.map(([type]) => type))).toEqual(new Set(Object.keys(FIELDS)));
  });

  test.each(messages)("%s is read", (_, text) => {
    expect(decodeText(text)).toEqual(JSON.parse(text));
  });

  test.each(messages)("%s is refused with any of its fields broken", (type, text) => {
    for (const key of Object.keys(JSON.parse(text)).filter((name) => name !== "type")) {
      const broken = { ...JSON.parse(text), [key]: { no: "such value" } };
      if (
        ["parameters", "localization", "costmap", "map3d", "terrain", "surface"].includes(type) &&
        ["values", "sensor", "faults"].includes(key)
      )
        broken[key] = [1];
      expect(() => decodeText(JSON.stringify(broken))).toThrow(expect.objectContaining({ code: `${type}.${key}` }));
    }
  });
});

describe("text frames", () => {
  const frame = {
    type: "frame",
    t: 1,
    playing: true,
    speed: 1,
    index: 2,
    count: 3,
    stamp: 0,
    pose: [0, 0, 0],
    sensor_pose: [0, 0, 0],
    scan_pose: [0, 0, 0],
    ranges: [1, null],
    angle_min: 0,
    angle_increment: 0.1,
    range_max: 10,
    auto: false,
  };

  test("a whole message is returned, with fields that this page does not know", () => {
    expect(decodeText(JSON.stringify({ ...frame, newer: 1 }))).toEqual({ ...frame, newer: 1 });
  });

  const hello = JSON.parse(vectors.messages[0] ?? "");

  test.each([
    ["a message", '{"type":"weather","rain":true}', "message.unknown"],
    ["a message named as a method", '{"type":"toString"}', "message.unknown"],
    ["a session kind", JSON.stringify({ ...hello, kind: "slam" }), "hello.kind"],
    ["a protocol", JSON.stringify({ ...hello, protocol: "gridbloom.v4" }), "hello.protocol"],
  ])("%s of a newer server means that the page is outdated", (_, text, code) => {
    let thrown: unknown;
    try {
      decodeText(text);
    } catch (error) {
      thrown = error;
    }
    expect(thrown).toBeInstanceOf(OutdatedPageError);
    expect(thrown).toHaveProperty("code", code);
  });

  test.each([
    ["not JSON", "{", "message.json"],
    ["a list", "[1]", "message.type"],
    ["null", "null", "message.type"],
    ["no type", "{}", "message.type"],
    ["a pose of two numbers", JSON.stringify({ ...frame, pose: [0, 0] }), "frame.pose"],
    ["a missing field", JSON.stringify({ ...frame, playing: undefined }), "frame.playing"],
    ["a number that is none", JSON.stringify({ ...frame, range_max: "10" }), "frame.range_max"],
    [
      "a tile of another size",
      '{"type":"geometry","layer":1,"epoch":1,"resolution":1,"rows":1,"cols":1,"origin":[0,0,0],"low":0,"high":1,"tile":32}',
      "geometry.tile",
    ],
  ])("%s is refused by name", (_, text, code) => {
    expect(() => decodeText(text)).toThrow(expect.objectContaining({ code }));
  });
});
