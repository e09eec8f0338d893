/** The cost of a cell over its distance from the nearest obstacle, as a curve that one grabs. */

import { useRef } from "preact/hooks";
import { costAt, factorFor, type Inflation } from "../../grid/costs";
import { useDrawing } from "../../ui/browser/useDrawing";
import { Handle } from "../../ui/Handle";
import { keyed, type Range, snap, written } from "../../ui/numbers";
import { toPixel } from "./scale";
import "./chart.css";

const HEIGHT = 190;
const [LEFT, RIGHT, TOP, BOTTOM] = [34, 12, 38, HEIGHT - 38];
const COSTS = [0, 100, 200, 254];

interface CostCurveProps {
  /** Radii of the robot's footprint, m. */
  readonly inscribed: number;
  readonly circumscribed: number;
  readonly inflation: Inflation;
  readonly ranges: Readonly<Record<keyof Inflation, Range>>;
  readonly onChange: (name: keyof Inflation, value: number) => void;
}

export function CostCurve({ inscribed, circumscribed, inflation, ranges, onChange }: CostCurveProps) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 400).value;
  const before = useRef({ radius: 0, at: 0 });
  const { inflation_radius: radius, cost_scaling_factor: factor } = inflation;
  // The axis does not move while the radius is dragged within its reach.
  const reach = Math.max(1, Math.ceil(2 * Math.max(radius * 1.15, circumscribed * 1.3)) / 2);
  const xs = { low: 0, high: reach, from: LEFT, to: width - RIGHT };
  const ys = { low: 0, high: 260, from: BOTTOM, to: TOP };
  const x = (distance: number): number => toPixel(distance, xs);
  const y = (cost: number): number => toPixel(cost, ys);
  const n = 120;
  const tail = Array.from({ length: n + 1 }, (_, i) => inscribed + ((radius - inscribed) * i) / n);
  const isInflated = radius > inscribed;
  const line = isInflated
    ? `M${x(0)} ${y(253)}H${x(inscribed)}${tail.map((d) => `L${x(d).toFixed(1)} ${y(costAt(d, inscribed, inflation)).toFixed(1)}`).join("")}V${y(0)}H${x(reach)}`
    : `M${x(0)} ${y(253)}H${x(radius)}V${y(0)}H${x(reach)}`;
  const grip = inscribed + Math.min(0.5 * (radius - inscribed), 0.7 / factor);
  const gripCost = costAt(grip, inscribed, inflation);
  const perPixel = reach / (xs.to - xs.from);
  const set = (name: keyof Inflation, value: number): void => {
    if (Number.isFinite(value)) onChange(name, snap(value, ranges[name]));
  };
  const key = (name: keyof Inflation, pressed: string, shift: boolean): boolean => {
    const next = keyed(pressed, shift, inflation[name], ranges[name]);
    if (next !== null) set(name, next);
    return next !== null;
  };
  return (
    <section class="cost-curve" ref={box} aria-label="Cost over the distance from an obstacle">
      <svg class="drawing" style={{ zoom: scale }} role="presentation" width={width} height={HEIGHT}>
        {COSTS.map((cost) => (
          <g key={cost} class="tick">
            <line x1={LEFT} x2={width - RIGHT} y1={y(cost)} y2={y(cost)} />
            <text x={LEFT - 6} y={y(cost) + 4} text-anchor="end">
              {cost}
            </text>
          </g>
        ))}
        {Array.from({ length: Math.floor(reach / 0.5) + 1 }, (_, i) => i / 2)
          .filter((tick) => reach <= 2 || tick % 1 === 0)
          .map((tick) => (
            <text key={tick} class="tick-x" x={x(tick)} y={BOTTOM + 17} text-anchor="middle">
              {tick}
            </text>
          ))}
        <text class="tick-x" x={width - RIGHT} y={HEIGHT - 6} text-anchor="end">
          distance from an obstacle (m)
        </text>
        <rect class="inscribed" x={x(0)} y={TOP} width={x(Math.min(inscribed, reach)) - x(0)} height={BOTTOM - TOP} />
        <line class="circumscribed" x1={x(circumscribed)} x2={x(circumscribed)} y1={TOP} y2={BOTTOM} />
        <path class="area" d={`${line}L${x(reach)} ${y(0)}L${x(0)} ${y(0)}Z`} />
        <path class="line" d={line} />
        <circle class="lethal" cx={x(0)} cy={y(254)} r={4} />
        <text class="mark inscribed" x={x(0) + 4} y={TOP - 23}>
          inscribed {written(inscribed, 2)} m
        </text>
        <text class="mark" x={x(circumscribed) + 4} y={TOP - 4}>
          circumscribed {written(circumscribed, 2)} m
        </text>
        {isInflated && (
          <Handle
            label="Cost scaling factor"
            sentence="How fast the cost falls outside the inscribed radius."
            axis="y"
            tone="tone-hit"
            now={factor}
            low={ranges.cost_scaling_factor.low}
            high={ranges.cost_scaling_factor.high}
            text={`${written(factor, 1)} per metre`}
            grab={{ x: x(grip) - 20, y: y(gripCost) - 20, width: 40, height: 40 }}
            onStart={() => {
              before.current = { radius: grip, at: gripCost };
            }}
            onDrag={(_, dy, fine) => {
              const { radius: at, at: cost } = before.current;
              const target = cost - (dy * (fine ? 0.2 : 1) * ys.high) / (BOTTOM - TOP);
              set("cost_scaling_factor", factorFor(target, at, inscribed));
            }}
            onKey={(pressed, shift) => key("cost_scaling_factor", pressed, shift)}
          >
            <circle class="handle-mark" cx={x(grip)} cy={y(gripCost)} r={7} />
          </Handle>
        )}
        <Handle
          label="Inflation radius"
          sentence="How far from an obstacle cells have a cost."
          axis="x"
          tone="tone-hit"
          now={radius}
          low={ranges.inflation_radius.low}
          high={ranges.inflation_radius.high}
          text={`${written(radius, 2)} metres`}
          grab={{ x: x(radius) - 20, y: BOTTOM - 34, width: 40, height: 44 }}
          onStart={() => {
            before.current = { radius, at: perPixel };
          }}
          onDrag={(dx, _, fine) => {
            set("inflation_radius", before.current.radius + dx * (fine ? 0.2 : 1) * before.current.at);
          }}
          onKey={(pressed, shift) => key("inflation_radius", pressed, shift)}
        >
          <line class="radius" x1={x(radius)} x2={x(radius)} y1={TOP + 32} y2={BOTTOM} />
          <rect class="handle-mark" x={x(radius) - 5} y={BOTTOM - 15} width={10} height={30} rx={5} />
        </Handle>
      </svg>
      <p>
        cost = 252 · exp(−{written(factor, 1)} (d − {written(inscribed, 2)})) up to {written(radius, 2)} m
      </p>
    </section>
  );
}
