import { describe, expect, it } from "vitest";
import type { Pose } from "../../wire/protocol";
import { stateOf } from "../common/counts";
import { counted, GEOMETRY, GREY, greysOf, MAP, pgmHeader, readValue, STATED, yamlText } from "./model";
import vectors from "./thresholds.vectors.json";

const GRID = {
  geometry: { ...vectors.geometry, origin: vectors.geometry.origin as unknown as Pose },
  logOdds: Float32Array.from(vectors.log_odds),
  observed: Uint8Array.from(vectors.observed),
};

describe("the map's file", () => {
  it.each(vectors.images)("has the mapper's bytes at $occupied and $free", ({ occupied, free, pgm }) => {
    const header = [...pgmHeader(GRID.geometry)].map((character) => character.charCodeAt(0));
    expect([...header, ...greysOf(GRID, occupied, free)]).toEqual(pgm);
  });

  it("has the mapper's yaml", () => {
    expect(yamlText(GRID.geometry, "map.pgm")).toBe(vectors.yaml);
  });

  it.each(vectors.readings)("is read as the mapper reads it at $occupied and $free", ({ occupied, free, values }) => {
    expect([GREY.occupied, GREY.unknown, GREY.free].map((grey) => readValue(grey, occupied, free))).toEqual(values);
  });

  it("comes back as it was written with the thresholds that it states, and not with a higher free_thresh", () => {
    const greys = greysOf(MAP, 0.65, 0.25);
    const { occupied, free } = STATED;
    const back = counted(greys, occupied, free);
    const states = [...MAP.observed.keys()].map((i) => stateOf(MAP, i));
    expect(back.occupied).toBe(states.filter((state) => state === "occupied").length);
    expect(back.free).toBe(states.filter((state) => state === "free").length);
    expect(counted(greys, occupied, 0.25)).toEqual({ ...back, free: back.free + back.unknown, unknown: 0 });
  });

  it("is of a map that is sure of some cells and not of others", () => {
    const { occupied, free, unknown } = counted(greysOf(MAP, 0.65, 0.25), STATED.occupied, STATED.free);
    expect(Math.min(occupied, free, unknown)).toBeGreaterThan(60);
    expect(occupied + free + unknown).toBe(GEOMETRY.rows * GEOMETRY.cols);
  });
});
