import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { effectiveNumber } from "../../grid/particleFilter";
import { linePath, toPixel } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { Handle } from "../../ui/Handle";
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

const SIZE = 232;
const MIDDLE = SIZE / 2;
const [INNER, OUTER, TIP] = [46, 86, 104];
/** Pointers beyond this number are drawn as one ring. */
const MOST = 120;

const at = (turn: number, radius: number): string => {
  const angle = 2 * Math.PI * (turn - 0.25);
  return `${(MIDDLE + radius * Math.cos(angle)).toFixed(1)} ${(MIDDLE + radius * Math.sin(angle)).toFixed(1)}`;
};

function sector(from: number, to: number): string {
  const wide = to - from > 0.5 ? 1 : 0;
  if (to - from > 0.999) return `${sector(0, 0.5)}${sector(0.5, 1)}`;
  return `M${at(from, INNER)}L${at(from, OUTER)}A${OUTER} ${OUTER} 0 ${wide} 1 ${at(to, OUTER)}L${at(to, INNER)}A${INNER} ${INNER} 0 ${wide} 0 ${at(from, INNER)}Z`;
}

interface WheelProps {
  readonly weights: Float64Array;
  /** How often each particle is drawn. */
  readonly counts: Int32Array;
  /** Where the first pointer is between two, 0 … 1; null where the draws are independent. */
  readonly share: number | null;
  readonly onShare: (share: number) => void;
}

/** The weights as sectors of a wheel, and pointers at equal distances: table 4.4. One drags the first of them. */
function Wheel({ weights, counts, share, onShare }: WheelProps) {
  const count = weights.length;
  const before = useRef(0);
  const sums = [0];
  for (const w of weights) sums.push((sums.at(-1) ?? 0) + w);
  const ring = [...weights.keys()].filter((i) => (weights[i] ?? 0) > 1e-4);
  const pointers = share === null ? [] : Array.from({ length: count }, (_, m) => (m + share) / count);
  const first = pointers[0] ?? 0;
  const [x, y] = at(first, TIP).split(" ").map(Number) as [number, number];
  const set = (value: number): void => onShare(Math.min(0.99, Math.max(0.01, value)));
  return (
    <svg class="wheel drawing" width={SIZE} height={SIZE} viewBox={`0 0 ${SIZE} ${SIZE}`} role="presentation">
      {ring.map((i) => (
        <path
          key={i}
          class={`wheel-sector${counts[i] ? " drawn" : ""}`}
          d={sector(sums[i] ?? 0, Math.min(1, sums[i + 1] ?? 1))}
        />
      ))}
      <path
        class="wheel-pointers"
        d={pointers
          .slice(0, MOST)
          .map((turn) => `M${at(turn, OUTER - 10)}L${at(turn, OUTER + 8)}`)
          .join("")}
      />
      <text x={MIDDLE} y={MIDDLE - 2} text-anchor="middle">
        {count}
      </text>
      <text class="wheel-unit" x={MIDDLE} y={MIDDLE + 16} text-anchor="middle">
        draws
      </text>
      {share !== null && (
        <Handle
          label="First pointer"
          sentence="Turns all pointers of the wheel at once: the one random number of the low-variance sampler."
          axis="x"
          tone="tone-robot"
          now={share}
          low={0}
          high={1}
          text={`${written(share, 2)} of the distance between two pointers`}
          grab={{ x: x - 20, y: y - 20, width: 40, height: 40 }}
          onStart={() => {
            before.current = share;
          }}
          onDrag={(dx, _, fine) => set(before.current + (dx * (fine ? 0.2 : 1) * count) / (2 * Math.PI * TIP))}
          onKey={(key, shift) => {
            const step = shift ? 0.01 : 0.05;
            const direction = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[key];
            if (direction) set(share + direction * step);
            return direction !== undefined;
          }}
        >
          <path class="wheel-first" d={`M${at(first, OUTER - 10)}L${at(first, TIP)}`} />
          <circle class="handle-mark" cx={x} cy={y} r={8} />
        </Handle>
      )}
    </svg>
  );
}

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
                The sensor says {seesDoor(now.robot) ? "“door”" : "“wall”"}: each particle has the weight <i>p</i>(
                <i>z</i> | <i>x</i>, <i>m</i>). <i>N</i>
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
