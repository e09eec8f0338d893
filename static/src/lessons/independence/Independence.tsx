import { computed, type Signal, useSignal } from "@preact/signals";
import { Fragment } from "preact";
import { useMemo } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import "./independence.css";
import { type BeamResult, gridMap, joint, likeliest, productOf, type SensorParameters } from "./model";

export const START: readonly BeamResult[] = ["passed", "passed", "none", "passed", "none"];
const NEXT: Record<BeamResult, BeamResult> = { none: "passed", passed: "ended", ended: "none" };
const WORDS: Record<BeamResult, string> = { none: "not measured", passed: "beam passed", ended: "beam ended here" };

const percent = (p: number): string => (p < 0.0995 ? `${written(100 * p, 1)} %` : `${written(100 * p, 0)} %`);

interface IndependenceProps {
  readonly sensor: Signal<SensorParameters>;
}

/** Five cells on the arc of a sonar echo: probabilities of a grid map, and of the joint distribution of all 32 maps. */
export function Independence({ sensor }: IndependenceProps) {
  const beamResults = useSignal<readonly BeamResult[]>(START);
  const both = useMemo(
    () =>
      computed(() => {
        const grid = gridMap(beamResults.value, sensor.value);
        return {
          grid: grid.map(probability),
          joint: joint(beamResults.value, sensor.value),
          nothing: productOf(0, grid),
          maps: likeliest(beamResults.value, sensor.value, 5),
        };
      }),
    [beamResults, sensor],
  );
  const now = both.value;
  const turn = (cell: number): void => {
    beamResults.value = beamResults.value.map((result, i) => (i === cell ? NEXT[result] : result));
  };
  return (
    <figure class="independence" aria-label="One sonar echo, five cells: independent cells and the joint distribution">
      <div class="independence-scene">
        <Cone beamResults={beamResults.value} grid={now.grid} joint={now.joint.marginals} onTurn={turn} />
      </div>
      <div class="independence-maps">
        <h3>Whole maps, the most probable first</h3>
        <div class="table-room">
          <table>
            <thead>
              <tr>
                <th scope="col">map</th>
                <th scope="col">joint</th>
                <th scope="col">product of cells</th>
              </tr>
            </thead>
            <tbody>
              {now.maps.map(({ map, joint: p, grid }) => (
                <tr key={map} class={map === 0 ? "nothing" : ""}>
                  <th scope="row">
                    <Strip map={map} cells={beamResults.value.length} />
                  </th>
                  <Bar p={p} tone="joint" />
                  <Bar p={grid} tone="grid" />
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      </div>
      <figcaption aria-live="polite">
        <span>
          Probability that the arc is <b>empty</b> in spite of the echo: joint{" "}
          <b class="joint-number">{percent(now.joint.maps[0] ?? 0)}</b>, grid map{" "}
          <b class="grid-number">{percent(now.nothing)}</b>.
        </span>
        <Button
          kind="quiet"
          icon="restart"
          label="Reset, with no cell measured by the narrow beam"
          onClick={() => {
            beamResults.value = START.map(() => "none");
          }}
        />
      </figcaption>
    </figure>
  );
}

function Bar({ p, tone }: { p: number; tone: "joint" | "grid" }) {
  return (
    <td class={`independence-bar ${tone}`}>
      <span style={{ width: `${100 * p}%` }} />
      <output aria-live="off">{percent(p)}</output>
    </td>
  );
}

function Strip({ map, cells }: { map: number; cells: number }) {
  const occupied = Array.from({ length: cells }, (_, i) => i).filter((i) => (map >> i) & 1);
  const words =
    occupied.length === 0
      ? "empty"
      : `occupied: cell${occupied.length > 1 ? "s" : ""} ${occupied.map((i) => i + 1).join(" and ")}`;
  return (
    <span class="map-strip" role="img" aria-label={words}>
      {Array.from({ length: cells }, (_, i) => (
        <i key={i} class={occupied.includes(i) ? "occupied" : "free"} />
      ))}
    </span>
  );
}

const WIDTH = 460;
const HEIGHT = 372;
const SENSOR = { x: 40, y: HEIGHT / 2 + 6 };
const RADIUS = 235;
/** Radius of the cone: its edge is within the drawing. */
const RIM = 262;
const SPREAD = 0.66;
const SIZE = 56;
/** Columns of the numbers, and the line of their names. */
const GRID_X = WIDTH - 104;
const JOINT_X = WIDTH - 40;
const HEAD_Y = 12;

/** The style of an element at a place of the drawing: text over it keeps its size while the drawing shrinks. */
const placed = (x: number, y: number) => ({ left: `${(100 * x) / WIDTH}%`, top: `${(100 * y) / HEIGHT}%` });

interface ConeProps {
  readonly beamResults: readonly BeamResult[];
  readonly grid: readonly number[];
  readonly joint: readonly number[];
  readonly onTurn: (cell: number) => void;
}

function Cone({ beamResults, grid, joint: marginals, onTurn }: ConeProps) {
  const n = beamResults.length;
  const angle = (i: number): number => SPREAD * ((2 * i) / (n - 1) - 1);
  const at = (i: number, r: number): readonly [number, number] => [
    SENSOR.x + r * Math.cos(angle(i)),
    SENSOR.y + r * Math.sin(angle(i)),
  ];
  const edge = SPREAD + 0.09;
  const rim = (a: number): string => `${SENSOR.x + RIM * Math.cos(a)} ${SENSOR.y + RIM * Math.sin(a)}`;
  return (
    <div class="cone-box">
      <svg class="cone" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="presentation">
        <path class="cone-body" d={`M${SENSOR.x} ${SENSOR.y}L${rim(-edge)}A${RIM} ${RIM} 0 0 1 ${rim(edge)}Z`} />
        {[0.35, 0.55, 0.75].map((share) => {
          const r = RADIUS * share;
          const point = (a: number): string => `${SENSOR.x + r * Math.cos(a)} ${SENSOR.y + r * Math.sin(a)}`;
          return (
            <path key={share} class="cone-wave" d={`M${point(-edge + 0.06)}A${r} ${r} 0 0 1 ${point(edge - 0.06)}`} />
          );
        })}
        {beamResults.map((result, i) => {
          const [x, y] = at(i, result === "ended" ? RADIUS - SIZE / 2 : RADIUS + 62);
          return result === "none" ? null : (
            <line
              key={`${i}-${result}`}
              class={`cone-result ${result}`}
              x1={SENSOR.x + 12}
              y1={SENSOR.y}
              x2={x}
              y2={y}
            />
          );
        })}
        <g class="robot-shape" transform={`translate(${SENSOR.x} ${SENSOR.y})`}>
          <circle r={14} />
          <path d="M3 -6L10 0L3 6" />
        </g>
      </svg>
      <span class="cone-head" style={placed(GRID_X, HEAD_Y)}>
        grid
      </span>
      <span class="cone-head" style={placed(JOINT_X, HEAD_Y)}>
        joint
      </span>
      {beamResults.map((result, i) => {
        const y = at(i, RADIUS)[1];
        return (
          <Fragment key={`${i}-${result}`}>
            <span class="grid-number" style={placed(GRID_X, y)}>
              {percent(grid[i] ?? 0)}
            </span>
            <span class="joint-number" style={placed(JOINT_X, y)}>
              {percent(marginals[i] ?? 0)}
            </span>
          </Fragment>
        );
      })}
      {beamResults.map((result, i) => {
        const [x, y] = at(i, RADIUS);
        return (
          <button
            key={`cell-${i + 1}`}
            type="button"
            class="cone-cell printed"
            aria-label={`Cell ${i + 1}: ${WORDS[result]}. Grid map ${percent(grid[i] ?? 0)}, joint ${percent(marginals[i] ?? 0)}. Press to change what the beam measured`}
            style={{
              ...placed(x, y),
              "--p": `${100 * (marginals[i] ?? 0)}%`,
            }}
            onClick={() => onTurn(i)}
          >
            {i + 1}
          </button>
        );
      })}
    </div>
  );
}
