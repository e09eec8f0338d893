/** The scenes of the stage in the order of the lecture. Each continues the one before it: the same floor and drive. */

import { computed } from "@preact/signals";
import { probability } from "../../grid/cellValues";
import { statisticsOf } from "../../grid/occupancyGrid";
import { beamModel, isCone, type SensorModelParameters } from "../../grid/sensorModel";
import { plural, signed, written } from "../../ui/numbers";
import { cellsOf, phantoms } from "../common/counts";
import { parameters } from "../common/parameters";
import { coneModel } from "../sonar/model";
import {
  algorithmView,
  cellSide,
  countingBeams,
  countingUpdate,
  driftError,
  laserHeight,
  mapKind,
  modelReading,
  mountError,
  noReturn,
  noReturnRange,
  peopleOn,
  peopleScans,
  pipelineBeam,
  polishedOn,
  scansAfter,
  sonarMethod,
  sonarSettings,
  visited,
  wallNoise,
  wallWindow,
} from "./controls";
import { CORNERS, DRIVE, LOW_TABLE_HEIGHT, POLISHED, sightings, TABLE, WALLS } from "./floor";
import { laterScene } from "./later";
import { FIELD, LOOP_GEOMETRY, loopMap, visitOf } from "./loop";
import { type Scene, type Shown, scene, WALL_CELL, WHOLE } from "./scene";
import { rangeAt, SONAR_REACH, USUAL } from "./sensing";
import { lookOfWall, STRETCH } from "./wall";

const DEGREE = Math.PI / 180;
/** Scan at which the table is taken away. */
const REMOVED = 62;

/** Everything that is really there. */
const SOLID = [...WALLS, POLISHED, ...TABLE];

/** ℓ and p of the selected cell. */
function cellInWords({ map, index }: Shown): string {
  if (index < 0 || map.observed[index] !== 1) return "The marked cell has not been observed.";
  const l = map.logOdds[index] ?? 0;
  return `The marked cell has ℓ = ${signed(l)}, which is p = ${written(probability(l), 2)}.`;
}

const WALL_WORDS = {
  thin: "The wall is thin",
  broken: "The wall is broken: beams that measured too much erase the hits of others",
  thick: "The wall is thick: the window marks cells that are free",
} as const;

const POLICY_WORDS = {
  ignore: "Ignored: beams without a return add nothing, and what lies farther away stays unknown.",
  free: "Counted as free: all cells up to the max range are cleared, also where a surface only reflects the light away.",
  hit: "Counted as a hit: a ring of walls appears where there is nothing.",
} as const;

/** The three views of the algorithm. */
export const ALGORITHM = {
  table: () => {
    const at = visitOf(Math.max(0, visited.value - 1));
    return scene({
      history: true,
      ladder: [at.before, at.after],
      scans: 30,
      marks: ["lines", "field"],
      resolution: LOOP_GEOMETRY.resolution,
      grid: loopMap(visited.value),
      view: WHOLE,
      caption: `Table 9.1 visits all cells. ${FIELD.length} of ${LOOP_GEOMETRY.rows * LOOP_GEOMETRY.cols} lie in the perceptual field of this scan, the outlined part. The current cell is ${at.inField ? `in the field: ℓ ${signed(at.before)} becomes ${signed(at.after)}.` : "outside it: ℓ stays."}`,
    });
  },
  program: () =>
    scene({
      scans: 30,
      marks: ["beams"],
      caption: "The loops swapped: beam by beam, over the cells of each. The map after 30 scans.",
    }),
  reading: () =>
    scene({
      poses: DRIVE.slice(25, 30),
      resolution: 0.2,
      marks: ["lines", "reading"],
      view: { x: 6.5, y: 2.5, width: 3.6, height: 2.6 },
      caption: "The steps of one reading: the last one changes the numbers of a few cells.",
    }),
} as const satisfies Record<(typeof algorithmView)["value"], () => Scene>;

/** Scans of the drive at the section on the sensor model; the newest has the reading of the curve. */
const MODEL_SCANS = 28;

/** The parameters of the section on the sensor model; its cones measure beams without a return as the lidar does. */
const modelValues = computed(() => parameters.value as SensorModelParameters & Readonly<Record<string, unknown>>);
/** The cone of the section on the sensor model; null where its model has a thin beam. */
export const modelCone = computed(() =>
  isCone(modelValues.value) ? { ...modelValues.value, no_return: "ignore" } : null,
);

/** The measured range of the stage's beam, or cone, at the section on the sensor model, metres. */
export const modelBeam = computed(() => {
  const at = MODEL_SCANS - 1;
  const { range } = rangeAt(DRIVE[at] ?? [0, 0, 0], at, USUAL, modelCone.value, pipelineBeam.value);
  return Number.isFinite(range) ? range : null;
});

/** What the stage shows of each model. */
function modelInWords(values: SensorModelParameters, now: Shown): string {
  const { hit, miss } = beamModel(values);
  switch (values.model) {
    case "sonar_cone":
      return `The cone of the curve on the map, one of 16 sonars on the same drive: ${signed(miss)} for the cells before the window, ${signed(hit)} on the whole arc in it${values.cone_profile === "gaussian" ? ", less away from the axis" : ""}. Walls become thick.`;
    case "moravec_elfes":
      return "The cone of the curve on the map, one of 16 sonars on the same drive. The map shows the greater of the two certainties of each cell; one echo is shared out over the arc, so it makes no cell certain.";
    case "hit_counting": {
      const [hits, misses] = statisticsOf(now.map).map((counts) => counts[now.index] ?? 0) as [number, number];
      return `The beam of the curve on the map. Every cell counts its beams: in the marked one ${plural(hits, "beam")} ended and ${misses} passed, so p = ${written(probability(now.map.logOdds[now.index] ?? 0), 2)}. Each further beam changes it less.`;
    }
    default:
      return `The beam of the curve on the map: ${signed(miss)} for the cells before the window, ${values.model === "smooth_ramp" ? `a ramp up to ${signed(hit)}` : signed(hit)} in it, nothing behind it. Every beam of the map uses these numbers.`;
  }
}

export const SCENES = {
  start: () =>
    scene({
      scans: 12,
      marks: ["beams"],
      caption:
        "A robot drives through a building and measures distances with a laser (lidar), 240 beams in each scan. Cells that its beams passed are free, cells in which they ended are occupied; it knows nothing about the rest.",
    }),
  grid: () =>
    scene({
      scans: 18,
      marks: ["lines"],
      view: { x: 3.4, y: 4.4, width: 4.6, height: 4.6 },
      caption: (now) =>
        `The floor as a grid of ${now.map.logOdds.length.toLocaleString("en")} cells with a side of 0.1 m, one number for each: ${plural(cellsOf(now.map, "occupied").length, "cell")} occupied, ${cellsOf(now.map, "free").length.toLocaleString("en")} free, the others unknown.`,
    }),
  landmarks: () =>
    scene({
      scans: 18,
      marks: mapKind.value === "corners" ? ["corners"] : [],
      bare: mapKind.value === "corners",
      caption: (now) => {
        if (mapKind.value === "grid")
          return `As a grid: ${now.map.logOdds.length.toLocaleString("en")} cells, one number for each. Walls, free space, and what is not yet known.`;
        const seen = sightings(DRIVE.slice(0, 18)).filter((count) => count > 0).length;
        return `Landmarks: ${seen} of ${CORNERS.length} corners seen, ${5 * seen} numbers (place and covariance). Each further sighting shrinks a circle. Walls and free space are not in this map.`;
      },
    }),
  cell: () =>
    scene({
      history: true,
      scans: 27,
      marks: ["lines", "beams", "values"],
      view: { x: WALL_CELL[0], y: 3.25, width: 0.32, height: 0.32 },
      caption: (now) => `One cell of the wall. Each beam that ends in it or passes it moves ℓ. ${cellInWords(now)}`,
    }),
  "log-odds": () =>
    scene({
      history: true,
      scans: 27,
      marks: ["lines", "values"],
      view: { x: WALL_CELL[0], y: 3.25, width: 0.44, height: 0.44 },
      caption: "In every cell: p, and below it ℓ. Each scan only adds to ℓ; p is computed to be shown.",
    }),
  model: () => {
    const values = modelValues.value;
    const { model, range_max, window } = values;
    const { hit, miss } = beamModel(values);
    const set = modelReading.value;
    const range = set === null || set <= range_max ? set : Number.POSITIVE_INFINITY;
    return scene({
      scans: MODEL_SCANS,
      marks: ["lines", modelCone.value ? "cone" : "beam"],
      view: { x: 5.9, y: 2.6, width: 3.4, height: 3 },
      conditions: { reading: range === null ? null : { scan: MODEL_SCANS - 1, beam: pipelineBeam.value, range } },
      config: {
        window,
        range_max,
        ramp: model === "smooth_ramp" ? { sigma: values.sigma, growth: values.sigma_growth } : null,
        prior_weight: model === "hit_counting" ? values.prior_weight : null,
        log_odds_hit: hit,
        log_odds_miss: miss,
      },
      cone: modelCone.value,
      caption: (now) => modelInWords(values, now),
    });
  },
  window: () =>
    scene({
      history: true,
      poses: DRIVE.slice(22, 34),
      resolution: 0.05,
      marks: ["noise"],
      view: { x: (STRETCH.from + STRETCH.to) / 2 + 0.3, y: 3.2, width: 2.7, height: 1.7 },
      conditions: { noise: wallNoise.value, beams: 120 },
      config: { window: wallWindow.value },
      caption: (now) => {
        const { look, thickness, broken } = lookOfWall(now.map);
        return `${WALL_WORDS[look]}: ${written(thickness, 1)} cells of 5 cm thick, ${Math.round(100 * broken)} % of it with holes or jumps. Noise σ = ${written(wallNoise.value, 2)} m, window ${written(wallWindow.value, 2)} m.`;
      },
    }),
  "no-return": () =>
    scene({
      scans: 29,
      conditions: { reach: noReturnRange.value },
      config: { no_return: noReturn.value },
      marks: ["beams"],
      caption: () => `Max range ${written(noReturnRange.value, 1)} m. ${POLICY_WORDS[noReturn.value]}`,
    }),
  endpoint: () =>
    scene({
      scans: 29,
      resolution: 0.1,
      marks: ["frame"],
      view: { x: 5, y: 3, width: 10.4, height: 6.6 },
      caption: () =>
        `From pose and reading to the end point, and from there to a cell: column and row are counted from the origin, in cells of ${written(cellSide.value, 2)} m.`,
    }),
  rays: () =>
    scene({
      scans: 30,
      resolution: 0.2,
      marks: ["lines", "beam"],
      view: { x: 6.5, y: 2.5, width: 2.6, height: 2.3 },
      caption: "Bresenham’s line from the robot’s cell to the cell of the end point: every cell but the last is free.",
    }),
  algorithm: () => ALGORITHM[algorithmView.value](),
  sonar: () =>
    scene({
      scans: 32,
      cone: coneModel(sonarMethod.value, sonarSettings.value, SONAR_REACH),
      marks: ["cones"],
      caption: (now) =>
        `The same drive with 16 sonars in place of the laser. An echo says how far, not where on its arc: ${sonarMethod.value === "sonar_cone" ? "walls become thick and doors narrow" : "shared out over the arc, one echo makes no cell certain"}. ${plural(cellsOf(now.map, "occupied").length, "cell")} are occupied.`,
    }),
  mount: () =>
    scene({
      scans: 56,
      conditions: { mountYaw: mountError.value * DEGREE },
      caption: (now) => {
        const wrong = phantoms(now.map, SOLID, 0.25).length;
        return `The map of the same readings, made with a mount that is rotated by ${written(mountError.value, 0)}°: ${plural(wrong, "occupied cell")} where no wall is.`;
      },
    }),
  forgetting: () =>
    scene({
      history: true,
      scans: REMOVED + scansAfter.value,
      view: { x: 8.9, y: 4.2, width: 5.6, height: 4 },
      cell: [9.2, 4.935],
      conditions: { tableUntil: REMOVED },
      marks: ["beams"],
      caption: (now) =>
        `The table was taken away ${plural(scansAfter.value, "scan")} ago, and the map still shows ${scansAfter.value > 12 ? "what is left of it" : "it"}. ${cellInWords(now)}`,
    }),
  counting: () =>
    scene({
      scans: 64,
      resolution: 0.1,
      view: { x: 7.76, y: 3.4, width: 1.5, height: 1.1 },
      conditions: { beams: countingBeams.value },
      config: { update: countingUpdate.value },
      marks: ["lines", "counts"],
      caption:
        countingUpdate.value === "per_beam"
          ? "In each cell: the number of beams of this one scan that pass it. Near the robot one scan counts many times."
          : "In each cell: one update by the scan, whatever the number of its beams.",
    }),
  odometry: () =>
    scene({
      scans: 77,
      conditions: { drift: driftError.value * DEGREE },
      marks: ["odometry"],
      caption: (now) => {
        const wrong = phantoms(now.map, SOLID, 0.25).length;
        return driftError.value === 0
          ? "With the true poses every wall is drawn once."
          : `The heading drifts ${written(driftError.value, 2)}° per scan; ${wrong === 0 ? "no wall is doubled yet" : `${plural(wrong, "occupied cell")} of doubled walls`}. Dashed: the true path.`;
      },
    }),
  polished: () =>
    scene({
      scans: 27,
      conditions: { polished: polishedOn.value },
      view: { x: 5.6, y: 1.9, width: 8.6, height: 3.8 },
      cell: [7.05, 0.435],
      marks: ["beams"],
      caption: () =>
        polishedOn.value
          ? "The broad line is polished. Beams that meet it at more than 30° from its normal are reflected away, so the map shows only the part that the robot has faced."
          : "Not polished, the wall scatters the light, and all of it is mapped.",
    }),
  people: () =>
    scene({
      scans: peopleScans.value,
      conditions: { people: peopleOn.value },
      view: { x: 5, y: 1.9, width: 7, height: 4.2 },
      cell: [5.15, 1.75],
      marks: ["beams"],
      caption: (now) => {
        const trail = phantoms(now.map, SOLID, 0.25).length;
        if (!peopleOn.value) return "Nobody walks, and the corridor is free.";
        return `Someone follows the robot along the corridor. ${plural(trail, "cell")} of the trail ${trail === 1 ? "is" : "are"} in the map.`;
      },
    }),
  "low-table": () => {
    const seen = laserHeight.value <= LOW_TABLE_HEIGHT;
    return scene({
      scans: 20,
      conditions: { lowTable: seen },
      view: { x: 2.7, y: 5.3, width: 4.8, height: 4.8 },
      cell: [1.85, 5.335],
      marks: ["low-table"],
      caption: seen
        ? "The laser’s plane cuts the low table: it is in the map, and looks like a table of any height."
        : "The dashed table is lower than the laser’s plane. The map calls its place free, and the robot would drive into it.",
    });
  },
  resolution: () =>
    scene({
      scans: 77,
      view: { x: 8.4, y: 2.6, width: 3.2, height: 2.4 },
      marks: ["lines"],
      caption: "The door and the pillar in cells of 10 cm. Beside it the same corner in cells of 1, 5 and 10 cm.",
    }),
  probable: () =>
    scene({
      scans: 72,
      conditions: { drift: driftError.value * DEGREE },
      view: { x: 9.6, y: 1.8, width: 5, height: 3.6 },
      marks: ["beams", "odometry"],
      caption:
        "The robot stands at its true pose; its newest scan is drawn from the pose of the odometry, so the end points lie beside the walls.",
    }),
  matching: () =>
    scene({
      scans: 72,
      view: { x: 9.6, y: 1.8, width: 5, height: 3.6 },
      marks: ["beams"],
      caption: "The same scan from its corrected pose: the end points lie on the walls of the map.",
    }),
  graph: () =>
    scene({
      scans: 77,
      marks: ["odometry"],
      caption: "The whole drive with corrected poses: each wall is drawn once.",
    }),
  file: () =>
    scene({
      scans: 77,
      trinary: true,
      caption: (now) =>
        `What the file keeps of the map: ${plural(cellsOf(now.map, "occupied").length, "cell")} occupied, ${cellsOf(now.map, "free").length.toLocaleString("en")} free, the others unknown.`,
    }),
  particles: () => laterScene("particles"),
  "sensor-models": () => laterScene("sensor-models"),
  kidnapping: () => laterScene("kidnapping"),
  layers: () => laterScene("layers"),
  inflation: () => laterScene("inflation"),
  path: () => laterScene("path"),
  lifetime: () => laterScene("lifetime"),
  stack: () => laterScene("stack"),
  octree: () => laterScene("octree"),
  tsdf: () => laterScene("tsdf"),
  terrain: () =>
    scene({
      scans: 77,
      trinary: true,
      caption: "This map says free or occupied. Outdoors the ground has slopes, and each patch gets a plane.",
    }),
  next: () =>
    scene({
      scans: 77,
      caption: `The whole drive: ${DRIVE.length} scans with 240 readings each. The log of a real robot has thousands.`,
    }),
} as const satisfies Record<string, () => Scene>;

export type SceneId = keyof typeof SCENES;

export const isScene = (id: string | undefined): id is SceneId => id !== undefined && id in SCENES;
