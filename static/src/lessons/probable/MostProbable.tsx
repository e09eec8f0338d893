import { type Signal, useComputed, useSignal } from "@preact/signals";
import { linePath } from "../../render/chart/scale";
import { Choice } from "../../ui/Choice";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Plot } from "../common/Plot";
import { Walls } from "../common/Scene";
import { Stage } from "../common/Stage";
import {
  FIRST,
  GEOMETRY,
  LAST,
  likelihood,
  motionModel,
  type PlaceName,
  POSITIONS,
  placeOf,
  posterior,
  squaredDistances,
} from "./model";
import "./probable.css";

const PLACES: readonly { readonly value: PlaceName; readonly label: string }[] = [
  { value: "cabinets", label: "with cabinets" },
  { value: "doors", label: "with doors" },
  { value: "bare", label: "bare" },
];
const SAYS = 5.8;
const Y = 1;
const HEIGHT = 150;
const PAD = { top: 12, bottom: 22 };
const WIDE = GEOMETRY.cols * GEOMETRY.resolution;

export interface Uncertainty {
  /** Standard deviations, metres: of the odometry's position, and of a reading. */
  readonly odometry: number;
  readonly reading: number;
}
export const UNCERTAINTY: Uncertainty = { odometry: 0.5, reading: 0.1 };

/** The two factors of the most probable pose over the position in a corridor, and their product. */
export function MostProbable({ uncertainty }: { readonly uncertainty: Signal<Uncertainty> }) {
  const name = useSignal<PlaceName>("cabinets");
  const says = useSignal(SAYS);
  const place = useComputed(() => placeOf(name.value));
  const squares = useComputed(() => squaredDistances(place.value));
  const fits = useComputed(() => likelihood(squares.value, uncertainty.value.reading));
  const moved = useComputed(() => motionModel(says.value, uncertainty.value.odometry));
  const product = useComputed(() => posterior(fits.value, moved.value));

  const { best, values } = product.value;
  const { truth, points, walls } = place.value;
  const set = (change: Partial<Uncertainty>): void => {
    uncertainty.value = { ...uncertainty.peek(), ...change };
  };
  const error = Math.abs(best - truth);
  return (
    <figure
      class="probable stack"
      aria-label="The most probable position in a corridor, and the factors that it comes from"
    >
      <Stage
        geometry={GEOMETRY}
        label="A corridor, the end points of a scan at the most probable position, and the odometry’s"
      >
        {(transform) => (
          <>
            <Walls transform={transform} walls={walls} />
            <path
              class="probable-dots"
              d={points.map(([x, y]) => `M${transform.x(best + x).toFixed(1)} ${transform.y(y).toFixed(1)}h0`).join("")}
            />
            <g class="probable-truth" transform={`translate(${transform.x(truth)} ${transform.y(Y)})`}>
              <circle r={13} />
            </g>
            <g class="probable-best" transform={`translate(${transform.x(best)} ${transform.y(Y)})`}>
              <RobotShape yaw={0.1} size={8} />
            </g>
            <DragHandle
              transform={transform}
              at={[says.value, Y]}
              label="Position by odometry"
              sentence="Moves the position that the odometry gives, along the corridor."
              text={`${written(says.value, 2)} m`}
              step={0.1}
              onMove={([x]) => {
                says.value = Math.min(LAST, Math.max(FIRST, x));
              }}
            >
              <path class="probable-says" d="M0 -14L10 0L0 14L-10 0Z" />
            </DragHandle>
          </>
        )}
      </Stage>
      <Plot height={HEIGHT} label="The likelihood of the scan, the motion model and their product over the position">
        {(width) => {
          const x = (metres: number): number => (metres / WIDE) * width;
          const y = (value: number): number => PAD.top + (1 - value) * (HEIGHT - PAD.top - PAD.bottom);
          const curve = (of: Float64Array): string => linePath(POSITIONS.map((at, k) => [x(at), y(of[k] ?? 0)]));
          const filled = (of: Float64Array): string => `${curve(of)}L${x(LAST)} ${y(0)}L${x(FIRST)} ${y(0)}Z`;
          return (
            <>
              <path class="probable-fits" d={filled(fits.value)} />
              <path class="probable-moved" d={curve(moved.value)} />
              <path class="probable-product" d={curve(values)} />
              <path class="probable-axis" d={`M${x(FIRST)} ${y(0)}H${x(LAST)}`} />
              <path class="probable-mark" d={`M${x(best)} ${y(1)}V${y(0)}`} />
              {[2, 4, 6, 8].map((tick) => (
                <text key={tick} x={x(tick)} y={HEIGHT - 6} text-anchor="middle">
                  {tick} m
                </text>
              ))}
            </>
          );
        }}
      </Plot>
      <p class="legend">
        <span>
          <span class="probable-swatch fits" /> the scan fits the map
        </span>
        <span>
          <span class="probable-swatch moved" /> the odometry
        </span>
        <span>
          <span class="probable-swatch product" /> their product
        </span>
        <span>(each scaled to a maximum of 1)</span>
      </p>
      <div class="figure-controls no-print">
        <Choice
          label="Corridor"
          options={PLACES}
          value={name.value}
          onChange={(value) => {
            name.value = PLACES.find((option) => option.value === value)?.value ?? "cabinets";
          }}
        />
        <Slider
          label="Odometry uncertainty"
          sentence="Standard deviation of the position by odometry."
          value={uncertainty.value.odometry}
          initial={UNCERTAINTY.odometry}
          low={0.05}
          high={2}
          step={0.05}
          unit="m"
          onInput={(odometry) => set({ odometry })}
        />
        <Slider
          label="Measurement uncertainty"
          sentence="Standard deviation of the distance from an end point to the wall that it belongs to."
          value={uncertainty.value.reading}
          initial={UNCERTAINTY.reading}
          low={0.02}
          high={0.5}
          step={0.01}
          unit="m"
          tone="beam"
          onInput={(reading) => set({ reading })}
        />
      </div>
      <figcaption class="number" aria-live="polite">
        The odometry (diamond) says {written(says.value, 2)} m, most probable (disc) is <b>{written(best, 2)} m</b>,
        true (ring) {written(truth, 2)} m: <b class="probable-error">{written(100 * error, 0)} cm off</b>.
      </figcaption>
    </figure>
  );
}
