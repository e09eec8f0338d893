/** The sensor models as draggable curves: the likelihood of a reading over its range or its distance from a wall. */

import { useRef } from "preact/hooks";
import {
  type BeamMixture,
  beamDensity,
  beamParts,
  fieldLikelihood,
  normalPeak,
  shortDensity,
} from "../../grid/rangeModels";
import { linePath, type Scale, ticks, toPixel, toValue } from "../../render/chart/scale";
import { useDrawing } from "../../ui/browser/useDrawing";
import { Handle } from "../../ui/Handle";
import { keyed, type Range, snap, written } from "../../ui/numbers";
import type { Parameter, Values } from "../../wire/protocol";
import "./localization.css";

/** Decades of likelihood shown; lower values are not distinguished. */
export const [LOWEST, HIGHEST] = [-4, 1.3];

interface LogScale {
  /** The pixel of a likelihood; the lower end for those below the scale. */
  readonly at: (likelihood: number) => number;
  /** The likelihood at a pixel, 0 below the axis. */
  readonly of: (pixel: number) => number;
}

function logScale(from: number, to: number): LogScale {
  const scale: Scale = { low: LOWEST, high: HIGHEST, from, to };
  return {
    at: (likelihood) => toPixel(Math.min(HIGHEST, Math.max(LOWEST, Math.log10(Math.max(likelihood, 1e-12)))), scale),
    of: (pixel) => {
      const power = toValue(pixel, scale);
      return power < LOWEST ? 0 : 10 ** Math.min(power, HIGHEST);
    },
  };
}

/** Distances at which a curve is drawn, closer together around a peak. */
function distances(reach: number, peak: number, sigma: number): readonly number[] {
  const even = Array.from({ length: 61 }, (_, i) => (reach * i) / 60);
  const near = Array.from({ length: 61 }, (_, i) => peak + sigma * (i / 7.5 - 4));
  return [...even, ...near].filter((z) => z >= 0 && z <= reach).sort((a, b) => a - b);
}

const HEIGHT = 230;
const [LEFT, RIGHT, TOP, BOTTOM] = [46, 42, 14, HEIGHT - 36];
const DECADES = [-4, -3, -2, -1, 0, 1];
/** Share of the longest range at which the map has an obstacle in the figure of the beam model. */
const EXPECTED = 0.6;
const FLOOR_AT = 0.84;

interface CurveProps {
  readonly values: Values;
  readonly rows: readonly Parameter[];
  /** The sensor's longest range, m. */
  readonly range_max: number;
  readonly set: (values: Values) => void;
}

interface Grip {
  readonly name: keyof BeamMixture | "laser_likelihood_max_dist";
  readonly label: string;
  readonly sentence: string;
  readonly axis: "x" | "y";
  readonly at: readonly [x: number, y: number];
  readonly tone: string;
  readonly unit: string;
  /** The value when the handle is at a pixel along its axis. */
  readonly of: (pixel: number) => number;
  readonly text: readonly [dx: number, dy: number, anchor: "start" | "middle" | "end"];
}

const NO_ROW: Range = { low: 0, high: 1, step: 0.01 };

export function SensorCurve({ values, rows, range_max, set }: CurveProps) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 400).value;
  const from = useRef(0);
  const isBeam = values.laser_model_type === "beam";
  const wallReach = Number(values.laser_likelihood_max_dist);
  const limit = Number(values.laser_max_range);
  const longest = limit > 0 ? Math.min(limit, range_max) : range_max;
  const mixture = { ...values, range_max: longest } as unknown as BeamMixture;
  const row = (name: string): Range => rows.find((row) => row.name === name) ?? NO_ROW;
  const reach = isBeam ? longest : Math.max(1, Math.ceil(2 * Math.max(1.25 * wallReach, 2 * mixture.sigma_hit)) / 2);
  const xs: Scale = { low: 0, high: reach, from: LEFT, to: width - RIGHT };
  const ys = logScale(BOTTOM, TOP);
  const expected = EXPECTED * longest;
  const below = longest * (1 - 1e-9); // at the longest range itself the only density is z_max
  const likelihood = (s: number): number =>
    isBeam ? beamDensity(Math.min(s, below), expected, mixture) : fieldLikelihood(s, mixture, wallReach);
  const points = distances(reach, isBeam ? expected : 0, mixture.sigma_hit);
  const path = (of: (s: number) => number): string => linePath(points.map((s) => [toPixel(s, xs), ys.at(of(s))]));
  const grips = isBeam ? beamGrips(mixture, expected, xs, ys) : fieldGrips(mixture, wallReach, xs, ys);
  const change = (name: string, value: number): void => {
    if (Number.isFinite(value)) set({ [name]: snap(value, row(name)) });
  };
  const sum = mixture.z_hit + mixture.z_rand + (isBeam ? mixture.z_short + mixture.z_max : 0);
  return (
    <figure
      class="sensor-curve"
      ref={box}
      aria-label={
        isBeam ? "Likelihood of a reading over its range" : "Likelihood of a reading over its distance from a wall"
      }
    >
      <svg class="drawing" style={{ zoom: scale }} role="presentation" width={width} height={HEIGHT}>
        {DECADES.map((power) => (
          <g key={power} class="tick">
            <line x1={LEFT} x2={width - RIGHT} y1={ys.at(10 ** power)} y2={ys.at(10 ** power)} />
            <text x={LEFT - 6} y={ys.at(10 ** power) + 4} text-anchor="end">
              {power < 0 ? written(10 ** power, -power) : 10 ** power}
            </text>
          </g>
        ))}
        {ticks(0, reach, (width - LEFT - RIGHT) / 56).map((tick) => (
          <text key={tick} class="tick-x" x={toPixel(tick, xs)} y={BOTTOM + 17} text-anchor="middle">
            {tick}
          </text>
        ))}
        <text class="tick-x" x={width - RIGHT} y={HEIGHT - 3} text-anchor="end">
          {isBeam ? "reading (m)" : "distance of its end from the nearest wall (m)"}
        </text>
        {isBeam && (
          <>
            <line class="expected" x1={toPixel(expected, xs)} x2={toPixel(expected, xs)} y1={TOP} y2={BOTTOM} />
            <path class="part" d={path((s) => beamParts(s, expected, mixture).hit)} />
            <path class="part" d={path((s) => shortDensity(s, expected, mixture))} />
            <line
              class="no-return"
              x1={width - RIGHT + 14}
              x2={width - RIGHT + 14}
              y1={BOTTOM}
              y2={ys.at(mixture.z_max)}
            />
          </>
        )}
        <path class="line" d={path(likelihood)} />
        {grips.map((grip) => {
          const [x, y] = grip.at;
          const value = Number(values[grip.name]);
          const { low, high, step } = row(grip.name);
          const text = `${grip.name} ${written(value, step < 0.01 ? 3 : 2)}`;
          const [dx, dy, anchor] = grip.text;
          return (
            <Handle
              key={grip.name}
              label={grip.label}
              sentence={grip.sentence}
              axis={grip.axis}
              tone={grip.tone}
              now={value}
              low={low}
              high={high}
              text={`${written(value, 3)}${grip.unit ? ` ${grip.unit}` : ""}`}
              grab={{ x: x - 20, y: y - 20, width: 40, height: 40 }}
              onStart={() => {
                from.current = grip.axis === "x" ? x : y;
              }}
              onDrag={(moveX, moveY, fine) => {
                change(grip.name, grip.of(from.current + (grip.axis === "x" ? moveX : moveY) * (fine ? 0.2 : 1)));
              }}
              onKey={(pressed, shift) => {
                const next = keyed(pressed, shift, value, row(grip.name));
                if (next !== null) change(grip.name, next);
                return next !== null;
              }}
            >
              <circle class="handle-mark" cx={x} cy={y} r={7} />
              <text x={x + dx} y={y + dy} text-anchor={anchor}>
                {text}
              </text>
            </Handle>
          );
        })}
      </svg>
      <figcaption>
        {isBeam
          ? "A beam that should end at the dashed line. At the right: no return, a share of all readings. "
          : "Each end point counts by its distance from the nearest wall; ranges of no return are left out. "}
        The shares sum to {written(sum, 2)}.
      </figcaption>
    </figure>
  );
}

function beamGrips(m: BeamMixture, expected: number, xs: Scale, ys: LogScale): readonly Grip[] {
  const perMetre = (xs.to - xs.from) / (xs.high - xs.low);
  const share = 1 - Math.exp(-m.lambda_short * expected);
  const peak = m.z_hit * normalPeak(m.sigma_hit);
  const shortAt = (z: number): number => shortDensity(z, expected, m);
  const middle = 0.55 * expected;
  const near = 0.06 * m.range_max;
  const floor = FLOOR_AT * m.range_max;
  return [
    {
      name: "z_hit",
      label: "z_hit",
      sentence: "Share of readings from surfaces that are in the map.",
      axis: "y",
      at: [toPixel(expected, xs), ys.at(peak)],
      tone: "tone-hit",
      unit: "",
      of: (pixel) => ys.of(pixel) / normalPeak(m.sigma_hit),
      text: [-12, 4, "end"],
    },
    {
      name: "sigma_hit",
      label: "sigma_hit",
      sentence: "Standard deviation of readings from surfaces that are in the map.",
      axis: "x",
      at: [toPixel(expected, xs) + Math.max(14, m.sigma_hit * perMetre), ys.at(0.607 * peak) + 14],
      tone: "tone-hit",
      unit: "metres",
      of: (pixel) => (pixel - toPixel(expected, xs)) / perMetre,
      text: [12, -6, "start"],
    },
    {
      name: "z_short",
      label: "z_short",
      sentence: "Share of readings from things before the expected surface.",
      axis: "y",
      at: [toPixel(near, xs), ys.at(shortAt(near))],
      tone: "tone-beam",
      unit: "",
      of: (pixel) => (ys.of(pixel) * share) / (m.lambda_short * Math.exp(-m.lambda_short * near)),
      text: [0, -13, "start"],
    },
    {
      name: "lambda_short",
      label: "lambda_short",
      sentence: "How fast the likelihood of unexpected short readings falls with the range.",
      axis: "y",
      at: [toPixel(middle, xs), ys.at(shortAt(middle))],
      tone: "tone-beam",
      unit: "per metre",
      // The curve through its value at the near handle, which does not move.
      of: (pixel) => Math.log(Math.max(shortAt(near), 1e-9) / Math.max(ys.of(pixel), 1e-9)) / (middle - near),
      text: [0, 22, "middle"],
    },
    {
      name: "z_rand",
      label: "z_rand",
      sentence: "Share of readings of any range.",
      axis: "y",
      at: [toPixel(floor, xs), ys.at(m.z_rand / m.range_max)],
      tone: "tone-miss",
      unit: "",
      of: (pixel) => ys.of(pixel) * m.range_max,
      text: [0, 22, "middle"],
    },
    {
      name: "z_max",
      label: "z_max",
      sentence: "Share of readings without return.",
      axis: "y",
      at: [xs.to + 14, ys.at(m.z_max)],
      tone: "tone-range",
      unit: "",
      of: (pixel) => ys.of(pixel),
      text: [20, -13, "end"],
    },
  ];
}

function fieldGrips(m: BeamMixture, reach: number, xs: Scale, ys: LogScale): readonly Grip[] {
  const floor = m.z_rand / m.range_max;
  return [
    {
      name: "z_hit",
      label: "z_hit",
      sentence: "Share of readings from surfaces that are in the map.",
      axis: "y",
      at: [toPixel(0, xs), ys.at(m.z_hit + floor)],
      tone: "tone-hit",
      unit: "",
      of: (pixel) => ys.of(pixel) - floor,
      text: [12, -9, "start"],
    },
    {
      name: "sigma_hit",
      label: "sigma_hit",
      sentence: "Standard deviation of readings from surfaces that are in the map.",
      axis: "x",
      at: [toPixel(m.sigma_hit, xs), ys.at(fieldLikelihood(m.sigma_hit, m, reach))],
      tone: "tone-hit",
      unit: "metres",
      of: (pixel) => ((pixel - xs.from) / (xs.to - xs.from)) * xs.high,
      text: [13, 5, "start"],
    },
    {
      name: "z_rand",
      label: "z_rand",
      sentence: "Share of readings of any range.",
      axis: "y",
      at: [toPixel(0.72 * reach, xs), ys.at(floor)],
      tone: "tone-miss",
      unit: "",
      of: (pixel) => ys.of(pixel) * m.range_max,
      text: [0, -13, "middle"],
    },
    {
      name: "laser_likelihood_max_dist",
      label: "Likelihood field distance",
      sentence: "Larger distances from an end point to the nearest occupied cell count as this distance.",
      axis: "x",
      at: [toPixel(reach, xs), BOTTOM],
      tone: "tone-beam",
      unit: "metres",
      of: (pixel) => ((pixel - xs.from) / (xs.to - xs.from)) * xs.high,
      text: [0, -14, "middle"],
    },
  ];
}
