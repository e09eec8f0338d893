import type { Signal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { type BeamMixture, beamParts, normalPeak } from "../../grid/rangeModels";
import { linePath, toPixel } from "../../render/chart/scale";
import { Handle } from "../../ui/Handle";
import { keyed, written } from "../../ui/numbers";
import { Variables } from "../../ui/text/Variables";
import { Plot } from "../common/Plot";
import { ValueHandle } from "../common/ValueHandle";
import { RANGE_MAX, type Share, withShare } from "./sensor";

const HEIGHT = 236;
const PAD = { left: 12, right: 26, top: 34, bottom: 38 };
/** Density at the top of the axis, which is that of a square root: the small parts are seen. */
const TOP = 2.5;
const POINTS = 240;
/** Where the handles of the flat parts are, metres. */
const SHORT_AT = 0.7;
const RAND_AT = 7;
const SHARE = { low: 0, high: 0.97, step: 0.01 };
const SIGMA = { low: 0.05, high: 1, step: 0.01 };
const EXPECTED = { low: 1.5, high: 6.5, step: 0.05 };

interface ForwardChartProps {
  readonly mix: Signal<BeamMixture>;
  /** The range that the map has. */
  readonly expected: Signal<number>;
}

interface Grip {
  readonly name: Share;
  readonly label: string;
  readonly tone: string;
  readonly sentence: string;
  readonly at: number;
  /** Density of the part for a share of 1 at this place. */
  readonly unit: number;
  readonly anchor: "start" | "middle" | "end";
}

/** p(z | x, m) over the reading z, with its four parts: one grabs each part. */
export function ForwardChart({ mix, expected }: ForwardChartProps) {
  const before = useRef(0);
  const now = mix.value;
  const z = expected.value;
  const share = 1 - Math.exp(-now.lambda_short * z);
  const grips: readonly Grip[] = [
    {
      name: "z_hit",
      label: "hit",
      tone: "tone-hit",
      sentence: "Share of readings from surfaces that are in the map.",
      at: z,
      unit: normalPeak(now.sigma_hit),
      anchor: "middle",
    },
    {
      name: "z_short",
      label: "short",
      tone: "tone-beam",
      sentence: "Share of readings from things before the expected surface: people, chairs.",
      at: SHORT_AT,
      unit: (now.lambda_short * Math.exp(-now.lambda_short * SHORT_AT)) / share,
      anchor: "start",
    },
    {
      name: "z_rand",
      label: "random",
      tone: "tone-miss",
      sentence: "Share of readings of any range.",
      at: RAND_AT,
      unit: 1 / RANGE_MAX,
      anchor: "end", // on a phone the bar of the max range is near
    },
    {
      name: "z_max",
      label: "max range",
      tone: "tone-robot",
      sentence: "Share of beams without a return: a probability at the greatest range, no density.",
      at: RANGE_MAX,
      unit: TOP,
      anchor: "end",
    },
  ];
  return (
    <Plot height={HEIGHT}>
      {(width) => {
        const xs = { low: 0, high: RANGE_MAX, from: PAD.left, to: width - PAD.right };
        const [top, bottom] = [PAD.top, HEIGHT - PAD.bottom];
        const x = (metres: number): number => toPixel(metres, xs);
        const y = (p: number): number => bottom - Math.sqrt(Math.min(1, p / TOP)) * (bottom - top);
        const perPixel = RANGE_MAX / (xs.to - xs.from);
        const samples = Array.from({ length: POINTS }, (_, i) => {
          const at = ((i + 0.5) * RANGE_MAX) / POINTS;
          return [at, beamParts(at, z, now)] as const;
        });
        const line = (of: (parts: ReturnType<typeof beamParts>) => number): string =>
          linePath(samples.map(([at, parts]) => [x(at), y(of(parts))]));
        const total = line(({ hit, short, rand }) => hit + short + rand);
        const sigmaY = y(now.z_hit * Math.exp(-0.5) * normalPeak(now.sigma_hit));
        return (
          <>
            <path class="particle-floor" d={`M${x(0)} ${bottom}H${x(RANGE_MAX)}`} />
            {Array.from({ length: RANGE_MAX + 1 }, (_, tick) => (
              <text key={tick} x={x(tick)} y={bottom + 17} text-anchor="middle">
                {tick}
              </text>
            ))}
            <text x={x(RANGE_MAX)} y={HEIGHT - 6} text-anchor="end">
              <Variables text="reading z (m)" inSvg />
            </text>
            <text x={x(0)} y={14}>
              <Variables text="p(z | x, m), square-root scale" inSvg />
            </text>
            <path class="forward-area" d={`${total}L${x(RANGE_MAX)} ${bottom}L${x(0)} ${bottom}Z`} />
            <path class="forward-part hit" d={line(({ hit }) => hit)} />
            <path class="forward-part short" d={line(({ short }) => short)} />
            <path class="forward-part rand" d={line(({ rand }) => rand)} />
            <path class="forward-total" d={total} />
            <path class="forward-max" d={`M${x(RANGE_MAX)} ${bottom}V${y(now.z_max * TOP)}`} />
            <ValueHandle
              label="Expected range"
              sentence="Where the map has something along this beam."
              axis="x"
              tone="tone-robot"
              value={z}
              range={EXPECTED}
              text={`${written(z, 2)} metres`}
              grab={{ x: x(z) - 20, y: bottom - 14, width: 40, height: 40 }}
              perPixel={perPixel}
              onValue={(range) => {
                expected.value = range;
              }}
            >
              <line class="forward-expected" x1={x(z)} x2={x(z)} y1={top} y2={bottom} />
              <rect class="handle-mark" x={x(z) - 5} y={bottom - 9} width={10} height={24} rx={5} />
            </ValueHandle>
            <ValueHandle
              label="σ"
              sentence="Standard deviation of readings from surfaces that are in the map."
              axis="x"
              tone="tone-hit"
              value={now.sigma_hit}
              range={SIGMA}
              text={`${written(now.sigma_hit, 2)} metres`}
              grab={{ x: x(z + now.sigma_hit) - 4, y: sigmaY - 20, width: 40, height: 40 }}
              perPixel={perPixel}
              onValue={(sigma) => {
                mix.value = { ...mix.peek(), sigma_hit: sigma };
              }}
            >
              <circle class="handle-mark" cx={x(z + now.sigma_hit)} cy={sigmaY} r={6} />
              <text class="forward-name hit" x={x(z + now.sigma_hit) + 11} y={sigmaY - 5}>
                σ {written(now.sigma_hit, 2)}
              </text>
            </ValueHandle>
            {grips.map((grip) => {
              const p = now[grip.name] * grip.unit;
              const [px, py] = [x(grip.at), y(p)];
              return (
                <Handle
                  key={grip.name}
                  label={grip.label}
                  sentence={grip.sentence}
                  axis="y"
                  tone={grip.tone}
                  now={now[grip.name]}
                  {...SHARE}
                  text={written(now[grip.name], 2)}
                  grab={{ x: px - 20, y: py - 24, width: 40, height: 36 }}
                  onStart={() => {
                    before.current = py;
                  }}
                  onDrag={(_, dy) => {
                    const rise = Math.max(0, (bottom - before.current - dy) / (bottom - top));
                    mix.value = withShare(mix.peek(), grip.name, (rise * rise * TOP) / grip.unit);
                  }}
                  onKey={(key, shift) => {
                    const next = keyed(key, shift, now[grip.name], SHARE);
                    if (next !== null) mix.value = withShare(mix.peek(), grip.name, next);
                    return next !== null;
                  }}
                >
                  <circle class="handle-mark" cx={px} cy={py} r={7} />
                  <text
                    class={`forward-name ${grip.name.slice(2)}`}
                    x={grip.anchor === "end" ? px + 14 : px}
                    y={py - 12}
                    text-anchor={grip.anchor}
                  >
                    {grip.label} {written(now[grip.name], 2)}
                  </text>
                </Handle>
              );
            })}
          </>
        );
      }}
    </Plot>
  );
}
