import { afterEach, describe, expect, it } from "vitest";
import { emptyGrid, INITIAL_CONFIG } from "../../grid/occupancyGrid";
import { cellIncrement, type SensorModelParameters } from "../../grid/sensorModel";
import { occupancyGridMapping, updatePerScan } from "../../grid/textbook";
import { parameters, setParameter } from "../common/parameters";
import { between, projection, type View } from "./camera";
import { pipelineBeam, wallNoise, wallWindow } from "./controls";
import { DRIVE, FLOOR, sightings } from "./floor";
import { historyOf } from "./history";
import { FIELD, LOOP_CELLS, LOOP_GEOMETRY, loopMap, visitOf } from "./loop";
import { backToPath, isOffPath, onPath } from "./path";
import { readingOf } from "./reading";
import { nowOf } from "./scene";
import { modelBeam, SCENES, type SceneId } from "./scenes";
import { believed, conesAt, geometryOf, scanAt, USUAL } from "./sensing";
import { lookOfWall } from "./wall";

const plan = (count: number) => ({
  geometry: geometryOf(0.2, FLOOR.width, FLOOR.height),
  conditions: USUAL,
  config: INITIAL_CONFIG,
  cone: null,
  poses: DRIVE.slice(0, count),
});

describe("the map of a scene", () => {
  it("is the one that the textbook makes of the same scans", () => {
    const history = historyOf(plan(6));
    expect(history.advance(plan(6), () => true)).toBe(false); // one scan at a time
    expect(history.count).toBe(1);
    while (!history.advance(plan(6), () => true));
    const grid = emptyGrid(plan(6).geometry);
    plan(6).poses.forEach((pose, i) => {
      occupancyGridMapping(grid, scanAt(pose, i, USUAL), pose, INITIAL_CONFIG);
    });
    expect(history.after(6).logOdds).toEqual(grid.logOdds);
    expect(history.after(6).observed).toEqual(grid.observed);
  });

  it("is kept for earlier scans, and made again after other ones", () => {
    const history = historyOf(plan(6));
    const sixth = history.after(6);
    expect(history.advance(plan(3), () => false)).toBe(true);
    expect(history.after(6)).toBe(sixth);
    const third = history.after(3);
    const other = { ...plan(3), poses: [...DRIVE.slice(0, 3), DRIVE[20] ?? [0, 0, 0]] as const };
    expect(history.advance(other, () => false)).toBe(true);
    expect(history.count).toBe(4);
    expect(history.after(3)).toBe(third);
    expect(history.after(4).logOdds).not.toEqual(third.logOdds);
  });

  it("exists for every scene", () => {
    for (const id of Object.keys(SCENES) as SceneId[]) {
      const scene = SCENES[id]();
      const now = nowOf(scene);
      expect(now.index, id).toBeGreaterThanOrEqual(0);
      expect(scene.caption(now), id).not.toMatch(/undefined|NaN/);
    }
  });
});

describe("the section on the sensor model", () => {
  const MODELS = ["step_window", "fixed_increments", "smooth_ramp", "sonar_cone", "moravec_elfes", "hit_counting"];
  afterEach(backToPath);

  it.each(MODELS)("maps with %s what its curve has along the beam", (model) => {
    setParameter("model", model);
    const scene = SCENES.model();
    expect(readingOf(scene, nowOf(scene), pipelineBeam.value)?.range).toBeCloseTo(modelBeam.value ?? Number.NaN, 6);
    expect(scene.caption(nowOf(scene))).not.toMatch(/undefined|NaN/);
    // One scan from the middle of a row of cells, which the beam follows.
    const z = 3.04;
    const conditions = { ...scene.conditions, beams: 1, reading: { scan: 0, beam: 0, range: z } };
    const { map } = nowOf({ ...scene, poses: [[0.6, 1.75, 0]], conditions });
    const first = 17 * map.geometry.cols + 6;
    const values = parameters.value as unknown as SensorModelParameters;
    for (let i = 0; i < 45; i++) {
      const empty = map.statistics?.[1][first + i] ?? 0;
      const gained = model === "moravec_elfes" ? -empty : map.logOdds[first + i];
      const expected = cellIncrement(i, z, values);
      // Of the arc of Moravec and Elfes the curve has the certainty before it is shared out.
      if (model !== "moravec_elfes" || expected < 0) expect(gained, `cell ${i}`).toBeCloseTo(expected, 5);
    }
  });

  it("shares one echo out over its arc, as Moravec and Elfes do", () => {
    setParameter("model", "moravec_elfes");
    const scene = SCENES.model();
    const { map } = nowOf({ ...scene, poses: [[6, 1.75, 0]] });
    const echoes = conesAt([6, 1.75, 0], 0, scene.conditions, scene.cone as SensorModelParameters).ranges;
    const occupied = map.statistics?.[0].reduce((sum, value) => sum + value, 0);
    // Arcs that overlap have a little less: Occ + O − Occ · O.
    expect(occupied).toBeGreaterThan(0.8 * echoes.filter(Number.isFinite).length);
    expect(occupied).toBeLessThanOrEqual(echoes.filter(Number.isFinite).length);
  });
});

describe("poses of drifting odometry", () => {
  it("equal the true ones without an error, and turn about the start with a constant one", () => {
    const pose = DRIVE[30];
    if (!pose) throw new Error("30 scans");
    expect(believed(pose, 30, USUAL, DRIVE)).toBe(pose);
    const off = believed(pose, 30, { ...USUAL, drift: 0.01 }, DRIVE);
    expect(off[2] - pose[2]).toBeCloseTo(0.3, 9);
    expect(Math.hypot(off[0] - pose[0], off[1] - pose[1])).toBeGreaterThan(0.2);
  });
});

describe("the loop of table 9.1", () => {
  it("gives the per-scan update when all cells are visited, and changes no cell outside the field", () => {
    const before = loopMap(0);
    const after = loopMap(LOOP_CELLS);
    const direct = { ...before, logOdds: before.logOdds.slice(), observed: before.observed.slice() };
    const pose = DRIVE[29] ?? [0, 0, 0];
    updatePerScan(direct, scanAt(pose, 29, { ...USUAL, reach: 4 }), pose, {
      ...INITIAL_CONFIG,
      update: "per_scan",
      window: LOOP_GEOMETRY.resolution,
      no_return: "free",
    });
    expect(after.logOdds).toEqual(direct.logOdds);
    const changed = [...after.logOdds.keys()].filter((i) => after.logOdds[i] !== before.logOdds[i]);
    expect(changed.length).toBeGreaterThan(50);
    expect(changed.every((i) => FIELD.includes(i))).toBe(true);
    expect(visitOf(0)).toMatchObject({ inField: false, before: 0, after: 0 });
  });
});

describe("the noisy wall", () => {
  it("is broken without a window, thin with one of three cells, thick with a wide one", () => {
    const look = (sigma: number, window: number) => {
      wallNoise.value = sigma;
      wallWindow.value = window;
      return lookOfWall(nowOf(SCENES.window()).map);
    };
    expect(look(0.05, 0).look).toBe("broken");
    expect(look(0.05, 0.15).look).toBe("thin");
    expect(look(0.05, 0.5).look).toBe("thick");
    expect(look(0.01, 0)).toMatchObject({ look: "thin" });
    backToPath();
  });
});

describe("landmarks", () => {
  it("are seen from where nothing stands between, and more often the longer the drive", () => {
    const few = sightings(DRIVE.slice(0, 3));
    const many = sightings(DRIVE);
    expect(few.filter((n) => n > 0).length).toBeLessThan(many.filter((n) => n > 0).length);
    expect(many.every((n, i) => n >= (few[i] ?? 0))).toBe(true);
  });
});

describe("the camera", () => {
  const whole: View = { x: 6, y: 4, width: 12, height: 8, strip: 0 };
  const cell: View = { x: 5.5, y: 3.2, width: 0.3, height: 0.3, strip: 1 };

  it("begins and ends at its views, and zooms by equal factors", () => {
    expect(between(whole, cell, 0)).toEqual(whole);
    expect(between(whole, cell, 1).x).toBeCloseTo(cell.x, 9);
    const widths = [0, 0.25, 0.5, 0.75, 1].map((t) => between(whole, cell, t).width);
    for (let i = 2; i < widths.length; i++)
      expect((widths[i] ?? 0) / (widths[i - 1] ?? 1)).toBeCloseTo((widths[1] ?? 0) / (widths[0] ?? 1), 9);
  });

  it("keeps what it ends at in the picture all the way", () => {
    for (let t = 0; t <= 1; t += 0.1) {
      const at = projection(between(whole, cell, t), { left: 0, top: 0, width: 600, height: 400 });
      expect(at.x(cell.x)).toBeGreaterThan(0);
      expect(at.x(cell.x)).toBeLessThan(600);
      expect(at.world(at.x(cell.x), at.y(cell.y))[1]).toBeCloseTo(cell.y, 9);
    }
  });
});

describe("the reader's own changes", () => {
  it("are known, and taken back all at once", () => {
    const [first, two] = [onPath(1), onPath("a")];
    expect(isOffPath.value).toBe(false);
    first.value = 2;
    two.value = "b";
    expect(isOffPath.value).toBe(true);
    backToPath();
    expect([first.value, two.value, isOffPath.value]).toEqual([1, "a", false]);
  });
});
