import { signal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { kldNumber, kldQuantile } from "../../grid/particleFilter";
import { linePath } from "../../render/chart/scale";
import { Handle } from "../../ui/Handle";
import { written } from "../../ui/numbers";
import { Plot } from "../common/Plot";
import { BINS, corridor, occupiedBins } from "./corridor";
import "./localization.css";

const HEIGHT = 230;
const [LEFT, RIGHT, TOP, BOTTOM] = [48, 56, 14, 186];
const MOST = 600;
const TICKS_N = [0, 200, 400, 600];
const TICKS_K = [0, 6, 12, 18, 24];
const ERROR = { initial: 0.05, low: 0.01, high: 0.5 };
const QUANTILE = { initial: 2.33, low: 0, high: 3 };
/** Bins at which the curve is grabbed. */
const [AT_QUANTILE, AT_ERROR] = [BINS / 2, BINS];

const limits = signal({ error: ERROR.initial, quantile: QUANTILE.initial });
const within = (value: number, { low, high }: typeof ERROR): number => Math.min(high, Math.max(low, value));

/** How many particles KLD sampling needs for a number of occupied bins; ε and q are dragged on the curve. */
export function ParticleNumber() {
  const { error, quantile } = limits.value;
  const bins = occupiedBins(corridor.value);
  const count = corridor.value.particles.length;
  const required = Math.ceil(kldNumber(bins, error, quantile));
  const set = (change: Partial<typeof limits.value>): void => {
    limits.value = { ...limits.peek(), ...change };
  };
  return (
    <figure class="particle-number" aria-label="Number of particles by the number of occupied bins">
      <Plot height={HEIGHT}>
        {(width) => {
          const x = (k: number): number => LEFT + (k / BINS) * (width - LEFT - RIGHT);
          const y = (n: number): number => BOTTOM - (Math.min(n, MOST) / MOST) * (BOTTOM - TOP);
          const sizes = Array.from({ length: 2 * BINS - 3 }, (_, i) => 2 + i / 2);
          const curve = linePath(sizes.map((k) => [x(k), y(kldNumber(k, error, quantile))]));
          return (
            <>
              <path class="particle-floor" d={`M${LEFT} ${BOTTOM}H${x(BINS)}M${LEFT} ${BOTTOM}V${TOP}`} />
              {TICKS_N.map((n) => (
                <text key={n} x={LEFT - 6} y={y(n) + 4} text-anchor="end">
                  {n}
                </text>
              ))}
              {TICKS_K.map((k) => (
                <text key={k} x={x(k)} y={BOTTOM + 17} text-anchor="middle">
                  {k}
                </text>
              ))}
              <text x={x(BINS / 2)} y={BOTTOM + 36} text-anchor="middle">
                occupied bins B of 0.5 m
              </text>
              <text x={LEFT + 6} y={TOP + 4}>
                particles M
              </text>
              <path class="belief-line" d={curve} />
              <path class="number-now" d={`M${x(bins)} ${BOTTOM}V${y(required)}H${LEFT}`} />
              <circle class="particle-drawn" cx={x(bins)} cy={y(required)} r={5} />
              <Grip
                label="q"
                sentence="Quantile of the normal distribution: how sure it is that the distance is below ε."
                range={QUANTILE}
                now={quantile}
                at={[x(AT_QUANTILE), y(kldNumber(AT_QUANTILE, error, quantile))]}
                onMove={(dy, from) => {
                  const n = kldNumber(AT_QUANTILE, error, from) - (dy * MOST) / (BOTTOM - TOP);
                  set({ quantile: within(kldQuantile(AT_QUANTILE, error, Math.max(0, n)), QUANTILE) });
                }}
                onStep={(way) => set({ quantile: within(quantile + 0.1 * way, QUANTILE) })}
              />
              <Grip
                label="ε"
                sentence="Largest Kullback-Leibler distance between the particles and the belief; less needs more particles."
                range={ERROR}
                now={error}
                at={[x(AT_ERROR), y(kldNumber(AT_ERROR, error, quantile))]}
                onMove={(dy, from) => {
                  const n = kldNumber(AT_ERROR, from, quantile) - (dy * MOST) / (BOTTOM - TOP);
                  set({ error: within((kldNumber(AT_ERROR, from, quantile) * from) / Math.max(1, n), ERROR) });
                }}
                onStep={(way) => set({ error: within(error - 0.005 * way, ERROR) })}
              />
            </>
          );
        }}
      </Plot>
      <figcaption class="number" aria-live="polite">
        The {count} particles of the corridor lie in {bins} of {BINS} bins: <i>M</i> = {required} for ε ={" "}
        {written(error, 3)} and <i>q</i> = {written(quantile, 2)}.
      </figcaption>
    </figure>
  );
}

interface GripProps {
  readonly label: string;
  readonly sentence: string;
  readonly range: typeof ERROR;
  readonly now: number;
  readonly at: readonly [number, number];
  /** `dy` pixels down from where it was grabbed, when the value was `from`. */
  readonly onMove: (dy: number, from: number) => void;
  readonly onStep: (way: number) => void;
}

/** A handle of the curve that moves up and down. */
function Grip({ label, sentence, range, now, at: [x, y], onMove, onStep }: GripProps) {
  const from = useRef(now);
  return (
    <Handle
      label={label}
      sentence={sentence}
      axis="y"
      tone="tone-robot"
      now={now}
      low={range.low}
      high={range.high}
      text={`${label} = ${written(now, 3)}`}
      grab={{ x: x - 20, y: y - 20, width: 40, height: 40 }}
      onStart={() => {
        from.current = now;
      }}
      onDrag={(_, dy, fine) => onMove(dy * (fine ? 0.2 : 1), from.current)}
      onKey={(key, shift) => {
        const direction = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[key];
        if (direction) onStep(direction * (shift ? 0.2 : 1));
        return direction !== undefined;
      }}
    >
      <circle class="handle-mark" cx={x} cy={y} r={8} />
      <text class="number-name" x={x + 14} y={y - 10}>
        {label}
      </text>
    </Handle>
  );
}
