import { computed, type Signal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import { cellAt } from "../../grid/lattice";
import { emptyGrid, emptyStatistics, indexOf, type OccupancyGrid } from "../../grid/occupancyGrid";
import { bound } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { signed, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Variables } from "../../ui/text/Variables";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Scene } from "../common/Scene";
import type { StageTransform } from "../common/Stage";
import { coneModel, type SonarScan, type SonarSettings, updateWide } from "./model";
import "./sonar.css";
import { GEOMETRY, POSES, RANGE_MAX, SONARS, sonarScan, WALLS } from "./world";

const ALL = POSES.length * SONARS;
const PROFILES = [
  { value: "flat", label: "flat" },
  { value: "gaussian", label: "weaker away from the axis" },
];

interface Taken {
  readonly pose: Pose;
  readonly scan: SonarScan;
}

/** The first `count` readings, scan by scan; the last scan may be incomplete. */
function takenIn(count: number, opening: number): readonly Taken[] {
  return POSES.slice(0, Math.ceil(count / SONARS)).map((pose, i) => {
    const scan = sonarScan(pose, opening);
    const readings = Math.min(SONARS, count - i * SONARS);
    return {
      pose,
      scan: { ...scan, ranges: scan.ranges.slice(0, readings), bearings: scan.bearings.slice(0, readings) },
    };
  });
}

const inside = ([x, y]: Point): Point => [Math.min(4.95, Math.max(0.05, x)), Math.min(3.35, Math.max(0.05, y))];

/** The same sonar readings combined by the Bayes filter and by the method of Moravec and Elfes. */
export function Sonar({ settings }: { settings: Signal<SonarSettings> }) {
  const count = useSignal(ALL);
  const probe = useSignal<Point>([4.65, 1.68]);
  const taken = useMemo(() => computed(() => takenIn(count.value, settings.value.opening)), [count, settings]);
  const bayes = useMemo(
    () =>
      computed<OccupancyGrid>(() => {
        const grid = emptyGrid(GEOMETRY);
        const model = coneModel("sonar_cone", settings.value, RANGE_MAX);
        for (const { pose, scan } of taken.value) updateWide(grid, scan, pose, model);
        return grid;
      }),
    [taken, settings],
  );
  const certain = useMemo(
    () =>
      computed(() => {
        const grid = emptyStatistics(GEOMETRY);
        const model = coneModel("moravec_elfes", settings.value, RANGE_MAX);
        for (const { pose, scan } of taken.value) updateWide(grid, scan, pose, model);
        return grid;
      }),
    [taken, settings],
  );
  const last = taken.value.at(-1);
  const index = indexOf(GEOMETRY, cellAt(GEOMETRY, probe.value[0], probe.value[1]));
  const l = bayes.value.logOdds[index] ?? 0;
  const seen = bayes.value.observed[index] === 1;
  const [occupied, empty] = certain.value.statistics;
  const isLast = (certain.value.observed[index] ?? 0) === 1;
  const panels = [
    {
      name: "Bayes filter, cell by cell",
      grid: bayes,
      text: seen ? `ℓ = ${signed(l)}, p = ${written(probability(l), 2)}` : "not observed",
    },
    {
      name: "Moravec and Elfes, 1985",
      grid: certain,
      text: isLast
        ? `occupied ${written(occupied[index] ?? 0, 2)}, empty ${written(empty[index] ?? 0, 2)}`
        : "not observed",
    },
  ];
  return (
    <figure class="sonar stack" aria-label="Sonar readings, combined in two ways">
      <div class="side-by-side">
        {panels.map(({ name, grid, text }) => (
          <div key={name}>
            <h3>{name}</h3>
            <Scene geometry={GEOMETRY} label={`The map by ${name}`} grid={grid} walls={WALLS}>
              {(transform) => (
                <>
                  {last && <LastCone transform={transform} taken={last} opening={settings.value.opening} />}
                  <DragHandle
                    transform={transform}
                    at={probe.value}
                    label={`Selected cell, ${name}`}
                    sentence="Selects the cell whose values are shown under both maps."
                    text={text}
                    tone="neutral"
                    step={GEOMETRY.resolution}
                    onMove={(point) => {
                      probe.value = inside(point);
                    }}
                  >
                    <path class="probe" d="M-13 0H-4M4 0H13M0 -13V-4M0 4V13" />
                  </DragHandle>
                </>
              )}
            </Scene>
            <p class="number" aria-live="polite">
              Under the cross:{" "}
              <b>
                <Variables text={text} />
              </b>
            </p>
          </div>
        ))}
      </div>
      <div class="figure-controls no-print">
        <Slider
          label="Number of readings"
          sentence="Number of sonar readings that both maps are made from, in the order of their time."
          {...bound(count)}
          initial={ALL}
          low={1}
          high={ALL}
          step={1}
        />
        <Choice
          label="Profile of the cone, Bayes filter"
          options={PROFILES}
          value={settings.value.profile}
          onChange={(profile) => {
            settings.value = { ...settings.peek(), profile: profile === "gaussian" ? "gaussian" : "flat" };
          }}
        />
      </div>
    </figure>
  );
}

/** The robot, and the cone of the newest reading with its arc. */
function LastCone({ transform, taken, opening }: { transform: StageTransform; taken: Taken; opening: number }) {
  const { pose, scan } = taken;
  const k = scan.ranges.length - 1;
  const range = scan.ranges[k] ?? 0;
  const z = Number.isFinite(range) ? range : scan.range_max;
  const bearing = pose[2] + (scan.bearings[k] ?? 0);
  const at = (angle: number): string =>
    `${transform.x(pose[0] + z * Math.cos(bearing + angle))} ${transform.y(pose[1] + z * Math.sin(bearing + angle))}`;
  const r = z * transform.metre;
  return (
    <>
      <path
        class="sonar-cone"
        d={`M${transform.x(pose[0])} ${transform.y(pose[1])}L${at(-opening / 2)}A${r} ${r} 0 0 0 ${at(opening / 2)}Z`}
      />
      {Number.isFinite(range) && (
        <path class="sonar-arc" d={`M${at(-opening / 2)}A${r} ${r} 0 0 0 ${at(opening / 2)}`} />
      )}
      <g transform={`translate(${transform.x(pose[0])} ${transform.y(pose[1])})`}>
        <RobotShape yaw={pose[2]} size={8} />
      </g>
    </>
  );
}
