import { useSignal } from "@preact/signals";
import { effectiveNumber } from "../../grid/particleFilter";
import { linePath, toPixel } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Plot } from "../common/Plot";
import type { StageTransform } from "../common/Stage";
import {
  belief,
  COUNT,
  centre,
  corridor,
  DOOR_WIDTH,
  DOORS,
  DRIVEN,
  type Draw,
  drawnOf,
  LENGTH,
  next,
  type Phase,
  seesDoor,
  start,
  weights,
} from "./corridor";
import "../../render/chart/chart.css";
import "./localization.css";
import { Wheel } from "./Wheel";

const HEIGHT = 316;
const PAD = 12;
/** Tops and bottoms of the rows. */
const CORRIDOR = 40;
const BELIEF = { top: 78, bottom: 146 };
const STEMS = { top: 174, bottom: 236 };
const DRAWN = { top: 264, bottom: 306 };

const NEXT: Readonly<Record<Phase, string>> = {
  weighed: "Resample",
  drawn: `Drive ${DRIVEN} m`,
  moved: "Take a reading",
};
const DRAWS = [
  { value: "low_variance", label: "low variance" },
  { value: "independent", label: "independent" },
];

/** A belief as a curve and as particles: weighed by a reading, resampled by their weights, moved. */
export function Particles() {
  const filter = corridor;
  const draw = useSignal<Draw>("low_variance");
  const share = useSignal(0.5);
  const now = filter.value;
  const w = weights(now);
  const drawn = drawnOf(now, draw.value, share.value);
  const counts = new Int32Array(w.length);
  for (const i of drawn) counts[i] = (counts[i] ?? 0) + 1;
  const kinds = counts.reduce((sum, count) => sum + (count > 0 ? 1 : 0), 0);
  const count = now.particles.length;
  return (
    <figure class="particles stack-narrow" aria-label="A belief as a curve and as particles">
      <div class="particles-both">
        <Plot height={HEIGHT}>
          {(width) => {
            const xs = { low: 0, high: LENGTH, from: PAD, to: width - PAD };
            const x = (metres: number): number => toPixel(metres, xs);
            const metre = (width - 2 * PAD) / LENGTH;
            const transform: StageTransform = {
              width,
              height: HEIGHT,
              metre,
              cell: metre,
              x,
              y: () => CORRIDOR,
              world: (px) => [(px - PAD) / metre, 0],
            };
            return (
              <>
                <Corridor x={x} />
                <DragHandle
                  transform={transform}
                  at={[now.robot, 0]}
                  label="Robot in the corridor"
                  sentence="Moves the robot; the filter is not told, and takes its next reading there."
                  text={`${written(now.robot, 1)} m, it sees ${seesDoor(now.robot) ? "a door" : "a wall"}`}
                  step={0.25}
                  onMove={([at]) => {
                    filter.value = { ...filter.peek(), robot: Math.min(11.6, Math.max(0.4, at)) };
                  }}
                >
                  <RobotShape yaw={0} size={10} />
                </DragHandle>
                <Belief x={x} values={belief(now)} />
                <Row top={STEMS.top} text={`${count} particles, height: weight`} />
                <Stems x={x} particles={now.particles} weights={w} />
                <Row top={DRAWN.top} text={`resampled: ${kinds} of ${count} are left`} />
                <Drawn x={x} particles={now.particles} counts={counts} />
              </>
            );
          }}
        </Plot>
        <Wheel
          weights={w}
          counts={counts}
          share={draw.value === "low_variance" ? share.value : null}
          onShare={(value) => {
            share.value = value;
          }}
        />
      </div>
      <div class="figure-controls no-print">
        <Button
          kind="primary"
          onClick={() => {
            filter.value = next(filter.peek(), draw.peek(), share.peek());
          }}
        >
          {NEXT[now.phase]}
        </Button>
        <Button
          icon="restart"
          onClick={() => {
            filter.value = start(count);
          }}
        >
          From the start
        </Button>
        <Choice
          label="Draw with"
          options={DRAWS}
          value={draw.value}
          sentence="Pointers at equal distances, turned by one random number (table 4.4), or each draw with a random number of its own."
          onChange={(value) => {
            draw.value = value === "independent" ? "independent" : "low_variance";
          }}
        />
        <Slider
          label="Particles"
          sentence="Number of particles; the filter starts again."
          value={count}
          initial={COUNT}
          low={6}
          high={200}
          step={2}
          onInput={(value) => {
            filter.value = start(value);
          }}
        />
      </div>
      <figcaption aria-live="polite">
        {
          {
            weighed: (
              <>
                The sensor says {seesDoor(now.robot) ? "“door”" : "“wall”"}: each particle has the weight p(z | x). N
                <sub>eff</sub> = {written(effectiveNumber(w), 1)} of {count}.
              </>
            ),
            drawn: "Drawn by their weights: all particles count the same again, and some are there several times.",
            moved: "Every particle has driven, each with its own error: the copies separate.",
          }[now.phase]
        }
      </figcaption>
    </figure>
  );
}

type Across = (metres: number) => number;

function Row({ top, text }: { top: number; text: string }) {
  return (
    <text x={PAD} y={top - 10}>
      {text}
    </text>
  );
}

/** A wall with doors in it. */
function Corridor({ x }: { x: Across }) {
  const ends = [0, ...DOORS.flatMap((door) => [door - DOOR_WIDTH / 2, door + DOOR_WIDTH / 2]), LENGTH];
  const wall = ends.map((at, i) => `${i % 2 === 0 ? "M" : "L"}${x(at)} 14`).join("");
  return (
    <>
      <path class="corridor-wall" d={`${wall}M${x(0)} 62H${x(LENGTH)}`} />
      {DOORS.map((door) => (
        <path
          key={door}
          class="corridor-door"
          d={`M${x(door - DOOR_WIDTH / 2)} 14v-9M${x(door + DOOR_WIDTH / 2)} 14v-9`}
        />
      ))}
    </>
  );
}

function Belief({ x, values }: { x: Across; values: Float64Array }) {
  const most = Math.max(...values);
  const y = (p: number): number => BELIEF.bottom - (p / most) * (BELIEF.bottom - BELIEF.top - 8);
  const line = linePath(Array.from(values, (p, i) => [x(centre(i)), y(p)]));
  return (
    <>
      <path class="belief-area" d={`${line}L${x(LENGTH)} ${BELIEF.bottom}L${x(0)} ${BELIEF.bottom}Z`} />
      <path class="belief-line" d={line} />
      <text x={x(7.25)} y={BELIEF.top + 10} text-anchor="middle">
        the belief, exact
      </text>
    </>
  );
}

function Stems({ x, particles, weights: w }: { x: Across; particles: Float64Array; weights: Float64Array }) {
  const most = Math.max(...w);
  return (
    <>
      <path class="particle-floor" d={`M${x(0)} ${STEMS.bottom}H${x(LENGTH)}`} />
      {Array.from(particles, (at, i) => {
        const tall = ((w[i] ?? 0) / most) * (STEMS.bottom - STEMS.top - 6);
        return (
          at >= 0 &&
          at <= LENGTH && (
            <g key={i} class="particle-stem">
              <path d={`M${x(at)} ${STEMS.bottom}v${-tall}`} />
              <circle cx={x(at)} cy={STEMS.bottom - tall} r={3} />
            </g>
          )
        );
      })}
    </>
  );
}

/** Dots on each other for a particle that is drawn several times. */
function Drawn({ x, particles, counts }: { x: Across; particles: Float64Array; counts: Int32Array }) {
  const most = Math.max(1, ...counts);
  const high = Math.min(7, (DRAWN.bottom - DRAWN.top) / most);
  return (
    <>
      <path class="particle-floor" d={`M${x(0)} ${DRAWN.bottom}H${x(LENGTH)}`} />
      {Array.from(counts, (count, i) => {
        const at = particles[i] ?? 0;
        return at < 0 || at > LENGTH
          ? null
          : Array.from({ length: count }, (_, k) => (
              <circle key={`${i} ${k}`} class="particle-drawn" cx={x(at)} cy={DRAWN.bottom - 4 - k * high} r={3} />
            ));
      })}
    </>
  );
}
