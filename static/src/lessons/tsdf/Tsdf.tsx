import { useSignal } from "@preact/signals";
import { bound, switched } from "../../ui/bound";
import { SwitchChip } from "../../ui/dock/SwitchChip";
import { signed, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { type Scene, scene, WALL_CELL } from "../stage/scene";
import {
  type Crossing,
  distancesOf,
  MOST_READINGS,
  MOVE,
  occupancyOf,
  occupiedOf,
  RESOLUTION,
  readingsOf,
  type Voxel,
  zeroCrossing,
} from "./model";
import { Profiles } from "./Profiles";
import "./tsdf.css";

export const tsdfScene = (): Scene =>
  scene({
    scans: 77,
    trinary: true,
    marks: ["lines"],
    view: { x: WALL_CELL[0], y: WALL_CELL[1], width: 2.4, height: 1.6 },
    caption:
      "A wall of the map in cells of 10 cm, which are occupied or not. Where in its cell the wall is, and which way it faces, is not in this map.",
  });

const FIRST = { wall: 1.23, truncation: 0.4, readings: 20, sigma: 0.02, maxWeight: 64 };
/** A place on the beam that is free for sure, and one behind the wall, m. */
const NEAR = 0.35;
const BEHIND = 1.95;

/** One beam, two beliefs: the log-odds and the signed distances along it after some readings. */
export function Tsdf() {
  const wall = useSignal(FIRST.wall);
  const truncation = useSignal(FIRST.truncation);
  const count = useSignal(FIRST.readings);
  const sigma = useSignal(FIRST.sigma);
  const maxWeight = useSignal(FIRST.maxWeight);
  const isCarved = useSignal(false);
  const isMoved = useSignal(false);

  const readings = readingsOf(wall.value, count.value, sigma.value, isMoved.value);
  const occupancy = occupancyOf(readings);
  const voxels = distancesOf(readings, {
    truncation: truncation.value,
    maxWeight: maxWeight.value,
    isCarved: isCarved.value,
    hasDropOff: false,
  });
  const crossing = zeroCrossing(voxels);
  return (
    <figure class="tsdf stack-narrow" aria-label="One beam as occupancy and as signed distance">
      <Profiles
        wall={wall.value}
        isMoved={isMoved.value}
        readings={readings}
        occupancy={occupancy}
        voxels={voxels}
        crossing={crossing}
        truncation={truncation.value}
        maxWeight={maxWeight.value}
        onWall={(metres) => {
          wall.value = metres;
        }}
        onTruncation={(metres) => {
          truncation.value = metres;
        }}
        onMaxWeight={(weight) => {
          maxWeight.value = weight;
        }}
      />
      <Answers
        wall={wall.value + (isMoved.value ? MOVE : 0)}
        occupancy={occupancy}
        voxels={voxels}
        crossing={crossing}
      />
      <div class="no-print stack-narrow">
        <div class="figure-controls">
          <Slider
            label="Readings"
            sentence="Number of beams along this row of voxels, one after the other."
            value={count.value}
            initial={FIRST.readings}
            low={1}
            high={MOST_READINGS}
            step={1}
            onInput={(value) => {
              count.value = Math.round(value);
            }}
          />
          <Slider
            label="Range noise σ"
            sentence="Standard deviation of the readings about the wall."
            unit="m"
            {...bound(sigma)}
            initial={FIRST.sigma}
            low={0}
            high={0.1}
            step={0.005}
          />
          <Slider
            label="Maximum weight"
            sentence="Weight at which a voxel’s mean becomes a moving average, so that the surface can still change."
            value={maxWeight.value}
            initial={FIRST.maxWeight}
            low={1}
            high={64}
            step={1}
            onInput={(value) => {
              maxWeight.value = Math.round(value);
            }}
          />
        </div>
        <div class="figure-controls">
          <SwitchChip
            label="Wall is moved halfway"
            title="For the second half of the readings the wall is 12 cm farther away."
            {...switched(isMoved)}
          />
          <SwitchChip
            label="Store free space too"
            title="Voxels farther in front of the wall than the truncation are stored too, with the truncation as their distance."
            {...switched(isCarved)}
          />
        </div>
      </div>
    </figure>
  );
}

interface AnswersProps {
  /** Where the wall is now, m. */
  readonly wall: number;
  readonly occupancy: readonly (number | null)[];
  readonly voxels: readonly Voxel[];
  readonly crossing: Crossing | null;
}

/** What each of the two maps answers. */
function Answers({ wall, occupancy, voxels, crossing }: AnswersProps) {
  const at = (metres: number): number => Math.floor(metres / RESOLUTION);
  const belief = (metres: number): string => {
    const l = occupancy[at(metres)] ?? null;
    return l === null ? "unknown" : `${l > 0 ? "occupied" : "free"}, ℓ = ${signed(l)}`;
  };
  const stored = (metres: number): string => {
    const { distance, weight } = voxels[at(metres)] as Voxel;
    return weight === 0 ? "nothing stored" : `D = ${signed(distance)} m`;
  };
  const rows = [
    {
      name: "Where is the wall?",
      cells: inCells(occupiedOf(occupancy)),
      distance: crossing
        ? `at ${written(crossing.at, 3)} m, ${written(1000 * Math.abs(crossing.at - wall), 0)} mm from the true place`
        : "no zero crossing",
    },
    {
      name: "Which way does it face?",
      cells: "a cell does not say",
      distance: crossing ? "to the side where D grows: the sensor’s" : "no zero crossing",
    },
    { name: `What is at ${written(NEAR, 2)} m?`, cells: belief(NEAR), distance: stored(NEAR) },
    { name: `What is at ${written(BEHIND, 2)} m?`, cells: belief(BEHIND), distance: stored(BEHIND) },
  ];
  return (
    <div class="table-room">
      <table class="plain-table tsdf-answers">
        <thead>
          <tr>
            <th scope="col">question</th>
            <th scope="col">occupancy</th>
            <th scope="col">signed distance</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(({ name, cells, distance }) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td>{cells}</td>
              <td>{distance}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** Occupied cells in words: each run of neighbours by its ends. */
function inCells(cells: readonly number[]): string {
  if (cells.length === 0) return "no cell is occupied";
  const runs: [first: number, last: number][] = [];
  for (const k of cells) {
    const run = runs.at(-1);
    if (run?.[1] === k - 1) run[1] = k;
    else runs.push([k, k]);
  }
  const ends = runs.map(
    ([first, last]) => `${written(first * RESOLUTION, 1)} … ${written((last + 1) * RESOLUTION, 1)} m`,
  );
  return `in ${cells.length === 1 ? "the cell" : "the cells"} ${ends.join(" and ")}`;
}
