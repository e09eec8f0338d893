import { toPixel } from "../../render/chart/scale";
import { plural, type Range, written } from "../../ui/numbers";
import { Plot } from "../common/Plot";
import { ValueHandle } from "../common/ValueHandle";
import { CLAMP, type Crossing, centreOf, MOVE, REACH, RESOLUTION, type Voxel } from "./model";

const HEIGHT = 404;
const [LEFT, RIGHT] = [46, 8];
/** Rows of the figure from above, px: the beam, log-odds, distances, weights. */
const BEAM_Y = 30;
const OCCUPANCY = { from: 168, to: 72, ...CLAMP };
const DISTANCE = { from: 316, to: 208, low: -0.6, high: 0.6 };
const WEIGHT = { from: 378, to: 344 };
const WALL: Range = { low: 0.65, high: 1.35, step: 0.01 };
const TRUNCATION: Range = { low: 0.2, high: 0.6, step: 0.02 };

interface ProfilesProps {
  /** Where the wall was at first, m. */
  readonly wall: number;
  readonly isMoved: boolean;
  readonly readings: readonly number[];
  readonly occupancy: readonly (number | null)[];
  readonly voxels: readonly Voxel[];
  readonly crossing: Crossing | null;
  readonly truncation: number;
  readonly maxWeight: number;
  /** Metres that one metre of the model stands for: a voxel is RESOLUTION · scale wide. */
  readonly scale?: number;
  readonly onWall: (metres: number) => void;
  readonly onTruncation: (metres: number) => void;
  readonly onMaxWeight: (weight: number) => void;
}

/** The beam, and below it what each map keeps of it, voxel by voxel; wall, truncation and weight are dragged. */
export function Profiles(props: ProfilesProps) {
  const { wall, isMoved, readings, occupancy, voxels, crossing, maxWeight, scale = 1 } = props;
  const truncation = Math.min(props.truncation, TRUNCATION.high);
  const digits = scale < 0.5 ? 3 : 2;
  const metres = (value: number): string => written(value * scale, digits);
  const now = wall + (isMoved ? MOVE : 0);
  const most = Math.max(readings.length, 2);
  const limit = Math.min(maxWeight, most);
  return (
    <Plot height={HEIGHT}>
      {(width) => {
        const xs = { low: 0, high: REACH, from: LEFT, to: width - RIGHT };
        const x = (metres: number): number => toPixel(metres, xs);
        const ell = (value: number): number => toPixel(value, OCCUPANCY);
        const d = (metres: number): number => toPixel(metres, DISTANCE);
        const side = x(RESOLUTION) - x(0);
        const perPixel = RESOLUTION / side;
        const known = [...voxels.keys()].filter((k) => (voxels[k] as Voxel).weight > 0);
        const line = known.map((k, i) => {
          const isNext = i > 0 && known[i - 1] === k - 1;
          return `${isNext ? "L" : "M"}${x(centreOf(k)).toFixed(1)} ${d((voxels[k] as Voxel).distance).toFixed(1)}`;
        });
        const w = (weight: number): number => toPixel(weight, { ...WEIGHT, low: 0, high: most });
        const knee = Math.max(0, now - truncation);
        return (
          <>
            <path
              class="tsdf-borders"
              d={Array.from({ length: voxels.length + 1 }, (_, k) => `M${x(k * RESOLUTION)} 48V${WEIGHT.from}`).join(
                "",
              )}
            />
            <path class="tsdf-beam" d={`M${x(0)} ${BEAM_Y}H${x(now)}`} />
            <path class="tsdf-sensor" d={`M${x(0)} ${BEAM_Y - 8}l14 8l-14 8Z`} />
            {isMoved && <path class="tsdf-wall before" d={`M${x(wall)} 14V${WEIGHT.from}`} />}
            <path class="tsdf-wall" d={`M${x(now)} 14V${WEIGHT.from}`} />
            <path class="tsdf-readings" d={readings.map((z) => `M${x(z).toFixed(1)} ${BEAM_Y + 4}v12`).join("")} />
            <text x={x(0) + 20} y={BEAM_Y - 8}>
              {plural(readings.length, "reading")}
            </text>

            <text class="tsdf-title" x={LEFT} y={OCCUPANCY.to - 8}>
              occupancy: ℓ of each cell
            </text>
            <Unknown cells={occupancy.map((l) => l === null)} text="unknown" x={x} scale={OCCUPANCY} />
            {occupancy.map((l, k) =>
              l === null ? null : (
                <rect
                  key={k}
                  class={l > 0 ? "tsdf-bar occupied" : "tsdf-bar free"}
                  x={x(k * RESOLUTION) + 1}
                  width={side - 2}
                  y={Math.min(ell(l), ell(0))}
                  height={Math.abs(ell(l) - ell(0))}
                />
              ),
            )}
            <path class="tsdf-zero" d={`M${LEFT} ${ell(0)}H${width - RIGHT}`} />
            {[-2, 0, 3].map((tick) => (
              <text key={tick} x={LEFT - 6} y={ell(tick) + 4} text-anchor="end">
                {written(tick, 0)}
              </text>
            ))}

            <text class="tsdf-title" x={LEFT} y={DISTANCE.to - 8}>
              signed distance D (m)
            </text>
            <Unknown cells={voxels.map(({ weight }) => weight === 0)} text="nothing stored" x={x} scale={DISTANCE} />
            <path class="tsdf-zero" d={`M${LEFT} ${d(0)}H${width - RIGHT}`} />
            <path
              class="tsdf-limit"
              d={`M${LEFT} ${d(truncation)}H${width - RIGHT}M${LEFT} ${d(-truncation)}H${width - RIGHT}`}
            />
            {[-truncation, 0, truncation].map((tick) => (
              <text key={tick} x={LEFT - 4} y={d(tick) + 4} text-anchor="end">
                {tick === 0 ? "0" : metres(tick)}
              </text>
            ))}
            <path class="tsdf-line" d={line.join("")} />
            {known.map((k) => {
              const { distance } = voxels[k] as Voxel;
              return (
                <circle
                  key={k}
                  class={distance < 0 ? "tsdf-dot behind" : "tsdf-dot"}
                  cx={x(centreOf(k))}
                  cy={d(distance)}
                  r={3.5}
                />
              );
            })}
            {crossing && <path class="tsdf-crossing" d={`M${x(crossing.at)} ${d(0) - 8}l7 8l-7 8l-7 -8Z`} />}

            <text class="tsdf-title" x={LEFT} y={WEIGHT.to - 6}>
              weight of each voxel
            </text>
            {voxels.map(({ weight }, k) => (
              <rect
                key={k}
                class="tsdf-weight"
                x={x(k * RESOLUTION) + 1}
                width={side - 2}
                y={w(weight)}
                height={WEIGHT.from - w(weight)}
              />
            ))}
            <path class="tsdf-limit" d={`M${LEFT} ${w(limit)}H${width - RIGHT}`} />
            <path class="tsdf-zero" d={`M${LEFT} ${WEIGHT.from}H${width - RIGHT}`} />
            {[0, 0.5, 1, 1.5, 2].map((tick) => (
              <text key={tick} x={x(tick)} y={WEIGHT.from + 17} text-anchor={tick === 2 ? "end" : "middle"}>
                {tick === 2 ? `${written(2 * scale, scale < 0.5 ? 2 : 0)} m` : tickOf(tick, scale)}
              </text>
            ))}

            <ValueHandle
              label="Wall"
              sentence="Moves the wall that is measured."
              axis="x"
              tone="tone-robot"
              value={wall}
              range={WALL}
              text={`${metres(now)} m from the sensor`}
              grab={{ x: x(now) - 20, y: 0, width: 40, height: 56 }}
              perPixel={perPixel}
              onValue={props.onWall}
            >
              <rect class="handle-mark" x={x(now) - 5} y={4} width={10} height={24} rx={5} />
              <text class="tsdf-wall-name" x={x(now) + 10} y={18}>
                wall, {metres(now)} m
              </text>
            </ValueHandle>
            <ValueHandle
              label="Truncation"
              sentence="Distance before and behind a reading within which voxels are updated."
              axis="x"
              tone="tone-robot"
              value={truncation}
              range={TRUNCATION}
              text={`${metres(truncation)} metres`}
              grab={{ x: x(knee) - 20, y: d(truncation) - 20, width: 40, height: 40 }}
              perPixel={-perPixel}
              onValue={props.onTruncation}
            >
              <circle class="handle-mark" cx={x(knee)} cy={d(truncation)} r={7} />
            </ValueHandle>
            <ValueHandle
              label="Maximum weight"
              sentence="Weight at which a voxel’s mean becomes a moving average."
              axis="y"
              tone="tone-robot"
              value={limit}
              range={{ low: 1, high: most, step: 1 }}
              text={maxWeight < most ? String(limit) : `${maxWeight}, which these readings do not exceed`}
              grab={{ x: width - RIGHT - 40, y: w(limit) - 20, width: 40, height: 40 }}
              perPixel={-most / (WEIGHT.from - WEIGHT.to)}
              onValue={props.onMaxWeight}
            >
              <circle class="handle-mark" cx={width - RIGHT - 12} cy={w(limit)} r={7} />
            </ValueHandle>
          </>
        );
      }}
    </Plot>
  );
}

const tickOf = (tick: number, scale: number): string =>
  scale < 0.5 ? written(tick * scale, 2) : written(tick, tick % 1 === 0 ? 0 : 1);

interface UnknownProps {
  /** Which cells hold nothing. */
  readonly cells: readonly boolean[];
  readonly text: string;
  readonly x: (metres: number) => number;
  readonly scale: { readonly from: number; readonly to: number };
}

/** A shade over the cells that hold nothing, with a word where there is room for it. */
function Unknown({ cells, text, x, scale }: UnknownProps) {
  const first = cells.flatMap((is, k) => (is && !cells[k - 1] ? [k] : []));
  return (
    <>
      {first.map((k) => {
        const rest = cells.slice(k).indexOf(false);
        const end = rest < 0 ? cells.length : k + rest;
        const [from, to] = [x(k * RESOLUTION), x(end * RESOLUTION)];
        return (
          <g key={k}>
            <rect class="tsdf-unknown" x={from} width={to - from} y={scale.to} height={scale.from - scale.to} />
            {to - from > 8 * text.length && (
              <text x={(from + to) / 2} y={0.25 * scale.to + 0.75 * scale.from + 4} text-anchor="middle">
                {text}
              </text>
            )}
          </g>
        );
      })}
    </>
  );
}
