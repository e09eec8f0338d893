import { type Signal, useSignal } from "@preact/signals";
import type { BeamMixture } from "../../grid/rangeModels";
import { toPixel } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { signed, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Variables } from "../../ui/text/Variables";
import { Plot } from "../common/Plot";
import { ValueHandle } from "../common/ValueHandle";
import { ForwardChart } from "./ForwardChart";
import { backwards, CELL, evidence, FIRST, RANGE_MAX } from "./sensor";
import "../../render/chart/chart.css";
import "./localization.css";

const EXPECTED = 5;
const PRIOR = 0.05;
const HEIGHT = 216;
const PAD = { left: 34, right: 12, top: 30, bottom: 38 };
/** Evidence at the ends of the axis. */
const MOST = 4;
const READING = { low: 0.5, high: 7.5, step: 0.05 };
/** The mapper's own model: its increments, in a window of this width. */
const WINDOW = 0.3;
const [HIT, MISS] = [0.85, -0.4];

/** The beam model forwards with its four parts, and the cells of the beam by three readings of it. */
export function SensorModels() {
  const mix = useSignal<BeamMixture>(FIRST);
  const expected = useSignal(EXPECTED);
  const z = useSignal(EXPECTED);
  const prior = useSignal(PRIOR);
  return (
    <figure class="sensor-models stack-narrow" aria-label="The beam model forwards and inverted">
      <div>
        <h3>Forwards: the map is known, which readings are likely?</h3>
        <ForwardChart mix={mix} expected={expected} />
      </div>
      <div>
        <h3>Inverse: a reading is known, which cells are occupied?</h3>
        <InverseChart mix={mix.value} z={z} prior={prior.value} />
      </div>
      <p class="legend">
        <Key tone="bayes">Bayes’ rule over all maps</Key>
        <Key tone="mapper">fixed increments</Key>
        <Key tone="backwards">logit of p(z | wall at r)</Key>
      </p>
      <div class="figure-controls no-print">
        <Slider
          label="Prior of a cell"
          sentence="Probability that a cell is occupied, before the reading."
          {...bound(prior)}
          initial={PRIOR}
          low={0.01}
          high={0.5}
          step={0.01}
        />
        <Button
          icon="restart"
          onClick={() => {
            mix.value = FIRST;
            expected.value = z.value = EXPECTED;
            prior.value = PRIOR;
          }}
        >
          Reset
        </Button>
      </div>
      <figcaption aria-live="polite">
        <Verdict mix={mix.value} z={z.value} prior={prior.value} />
      </figcaption>
    </figure>
  );
}

interface ChartProps {
  readonly mix: BeamMixture;
  readonly z: Signal<number>;
  readonly prior: number;
}

/** What is said about the cells half way to the reading, at it, and behind it. */
function Verdict({ mix, z, prior }: { mix: BeamMixture; z: number; prior: number }) {
  const bayes = evidence(z, mix, prior);
  const read = backwards(z, mix);
  const cell = (s: number): number => Math.min(bayes.length - 1, Math.floor(s / CELL));
  const [before, at, behind] = [cell(z / 2), cell(z), cell(z + 4 * mix.sigma_hit)];
  const per = (values: Float64Array, k: number): string => signed(values[k] ?? 0, 1);
  return (
    <>
      Halfway to the reading, at it, and behind it, Bayes’ rule adds {per(bayes, before)}, {per(bayes, at)} and{" "}
      {per(bayes, behind)}. Read backwards and clipped, the forward model gives {per(read, before)}, {per(read, at)} and{" "}
      {per(read, behind)}: cells that were seen to be free and cells that were never seen look alike.
    </>
  );
}

function InverseChart({ mix, z, prior }: ChartProps) {
  const at = z.value;
  const mapper = (s: number): number => (Math.abs(s - at) <= WINDOW / 2 ? HIT : s < at ? MISS : 0);
  return (
    <Plot height={HEIGHT}>
      {(width) => {
        const xs = { low: 0, high: RANGE_MAX, from: PAD.left, to: width - PAD.right };
        const [top, bottom] = [PAD.top, HEIGHT - PAD.bottom];
        const x = (metres: number): number => toPixel(metres, xs);
        const y = (l: number): number =>
          bottom - ((Math.min(MOST, Math.max(-MOST, l)) + MOST) / (2 * MOST)) * (bottom - top);
        const steps = (values: ArrayLike<number>): string =>
          Array.from(
            values,
            (_, i) => `${i ? "V" : `M${x(0)} `}${y(values[i] ?? 0).toFixed(1)}H${x((i + 1) * CELL).toFixed(1)}`,
          ).join("");
        const read = backwards(at, mix);
        const bayes = evidence(at, mix, prior);
        return (
          <>
            {[-MOST, 0, MOST].map((l) => (
              <g key={l}>
                <path class="inverse-line" d={`M${x(0)} ${y(l)}H${x(RANGE_MAX)}`} />
                <text x={PAD.left - 6} y={y(l) + 4} text-anchor="end">
                  {signed(l, 0)}
                </text>
              </g>
            ))}
            {Array.from({ length: RANGE_MAX + 1 }, (_, tick) => (
              <text key={tick} x={x(tick)} y={bottom + 17} text-anchor="middle">
                {tick}
              </text>
            ))}
            <text x={x(RANGE_MAX)} y={HEIGHT - 6} text-anchor="end">
              distance r of a cell along the beam (m)
            </text>
            <text x={0} y={14}>
              evidence for occupied, ℓ − ℓ₀
            </text>
            <path
              class="inverse-backwards"
              d={Array.from(
                read,
                (p, i) => `${i ? "L" : "M"}${x((i + 0.5) * CELL).toFixed(1)} ${y(p).toFixed(1)}`,
              ).join("")}
            />
            <path class="inverse-mapper" d={steps(bayes.map((_, i) => mapper((i + 0.5) * CELL)))} />
            <path class="inverse-bayes" d={steps(bayes)} />
            <ValueHandle
              label="Reading z"
              sentence="The measured range; the curves follow."
              axis="x"
              tone="tone-beam"
              value={at}
              range={READING}
              text={`${written(at, 2)} metres`}
              grab={{ x: x(at) - 20, y: bottom - 14, width: 40, height: 40 }}
              perPixel={RANGE_MAX / (xs.to - xs.from)}
              onValue={(reading) => {
                z.value = reading;
              }}
            >
              <line class="inverse-reading" x1={x(at)} x2={x(at)} y1={top} y2={bottom} />
              <rect class="handle-mark" x={x(at) - 5} y={bottom - 9} width={10} height={24} rx={5} />
              <text class="forward-name short" x={x(at)} y={top - 6} text-anchor="middle">
                z {written(at, 2)} m
              </text>
            </ValueHandle>
          </>
        );
      }}
    </Plot>
  );
}

function Key({ tone, children }: { tone: string; children: string }) {
  return (
    <span>
      <svg class="inverse-swatch" viewBox="0 0 36 6" aria-hidden="true">
        <path class={`inverse-${tone}`} d="M0 3H36" />
      </svg>{" "}
      <Variables text={children} />
    </span>
  );
}
