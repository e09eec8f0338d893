import { probability } from "../../grid/cellValues";
import { beamModel, cellIndexAt, halfWindow, increment } from "../../grid/sensorModel";
import { ticks, toPixel } from "../../render/chart/scale";
import { Handle } from "../../ui/Handle";
import { signed, written } from "../../ui/numbers";
import type { Controls } from "./controls";
import { level } from "./handles";
import { RangeMaxFlag, ReadingLabel, WindowEdges } from "./sharedHandles";
import type { ProfileView } from "./view";

/** Ticks of the probability axis by priority; if space is short, the later ones are left out. */
const PROBABILITIES = [0.5, 0.2, 0.8, 0.7, 0.3, 0.9, 0.1, 0.95, 0.05, 0.6, 0.4, 0.99, 0.01];

/** The two vertical axes: evidence in log-odds, and the resulting probability of a cell that had its prior. */
function Axes({ view }: { view: ProfileView }) {
  const { curve, width } = view.layout.value;
  const scale = view.yScale.value;
  const prior = view.values.value.log_odds_prior;
  const y = (evidence: number): number => toPixel(evidence, scale);
  const shown: { readonly p: number; readonly at: number }[] = [];
  for (const p of PROBABILITIES) {
    const at = y(Math.log(p / (1 - p)) - prior);
    const crowded = shown.some((label) => Math.abs(label.at - at) < 19);
    if (!crowded && at > curve.top + 3 && at < curve.bottom - 1) shown.push({ p, at });
  }
  return (
    <g>
      {ticks(scale.low, scale.high, Math.min(6, (curve.bottom - curve.top) / 20)).map((tick) => (
        <g key={tick} class="tick">
          <line class={tick === 0 ? "zero" : "grid"} x1={curve.left} x2={curve.right} y1={y(tick)} y2={y(tick)} />
          <text x={curve.left - 7} y={y(tick) + 4} text-anchor="end">
            {tick === 0 ? "0" : signed(tick, tick % 1 === 0 ? 0 : 1)}
          </text>
        </g>
      ))}
      {shown.map(({ p, at }) => (
        <g key={p} class="tick">
          <line x1={curve.right} x2={curve.right + 4} y1={at} y2={at} />
          <text x={curve.right + 7} y={at + 4} text-anchor="start">
            {written(p, 2)}
          </text>
        </g>
      ))}
      <AxisTitle
        x={13}
        y={(curve.top + curve.bottom) / 2}
        text="evidence Δℓ, log-odds"
        high={curve.bottom - curve.top}
      />
      <AxisTitle
        x={width - 5}
        y={(curve.top + curve.bottom) / 2}
        text="p after one beam"
        high={curve.bottom - curve.top}
      />
    </g>
  );
}

/** The title of a vertical axis, read from below, if the axis is long enough for it. */
function AxisTitle({ x, y, text, high }: { x: number; y: number; text: string; high: number }) {
  const short = text.replace(/,? (log-odds|after one beam)$/, "");
  return (
    <text class="axis-title" transform={`translate(${x} ${y}) rotate(-90)`} text-anchor="middle">
      {high > 6.2 * text.length ? text : short}
    </text>
  );
}

/** Half the width of a character of a label, and the least gap between two adjacent labels, pixels. */
const HALF_CHARACTER = 3.3;
const LABEL_GAP = 8;
/** Height of a line of a label, pixels. */
const LABEL_HEIGHT = 15;

const labelWidth = (text: string): number => 2 * HALF_CHARACTER * text.length;

/** Length of the arrow at an edge of the window with the gap before it, pixels. */
const ARROW = 18;

/** Names of the two levels in the models, if they differ. */
const NAMES: Readonly<Record<string, { readonly hit: string; readonly miss: string }>> = {
  step_window: { hit: "Probability of a cell hit", miss: "Probability of a cell passed" },
  hit_counting: { hit: "Change by the first hit", miss: "Change by the first miss" },
};

/** Distances from `low` to `high`, close enough for a smooth line. */
const rampPoints = (low: number, high: number): readonly number[] =>
  Array.from({ length: 49 }, (_, i) => low + ((high - low) * i) / 48);

/** The profile around the reading: a curve in which every part can be dragged. */
export function Curve({ view, controls }: { view: ProfileView; controls: Controls }) {
  const { curve, strip } = view.layout.value;
  const values = view.values.value;
  const xs = view.xScale.value;
  const ys = view.yScale.value;
  const z = view.z.value;
  const noReturn = view.noReturn.value;
  const model = beamModel(values);
  const prior = values.log_odds_prior;
  const half = halfWindow(z, values);
  const clamp = (pixel: number): number => Math.min(curve.right, Math.max(curve.left, pixel));
  const x = (s: number): number => clamp(toPixel(s, xs));
  const y = (evidence: number): number => toPixel(evidence, ys);
  const y0 = y(0);

  const frees = !noReturn || values.no_return === "free";
  const freeEnd = noReturn ? values.range_max : Math.max(0, z - half);
  const freeTo = frees ? x(freeEnd) : curve.left;
  const hitFrom = noReturn ? freeTo : x(Math.max(0, z - half));
  const hitTo = noReturn ? freeTo : x(z + half);
  const zx = x(z);
  const narrow = view.width.value < 560;
  // A low curve has no room for the window's label above its top.
  const low = curve.bottom - curve.top < 110;
  // With r = 0 the profile is a line at z. In the grid, the whole cell that contains the endpoint gets its evidence.
  const cell = cellIndexAt(z, values.resolution) * values.resolution;
  const hit = level("hit", values, controls.bounds);
  const miss = level("miss", values, controls.bounds);
  const labelFrom = Math.max(hitTo, zx + 15) + 8;
  const labelTo = Math.min(hitFrom, zx - 15) - 8;
  const isRamp = values.model === "smooth_ramp" && !noReturn;
  const windowText = half === 0 ? "w 0: one cell" : `${isRamp ? "4σ" : "w"} ${written(2 * half, 2)} m`;
  const hitText = `${narrow ? "" : "hit "}${signed(model.hit)} → p ${written(probability(prior + model.hit), 2)}${low && !narrow ? `, ${windowText}` : ""}`;
  const missText = `${narrow || freeTo - curve.left < 150 ? "" : "miss "}${signed(model.miss)} → p ${written(probability(prior + model.miss), 2)}`;
  // The label of a hit is on the side that has room for it; if neither has, it is only the increment.
  const hitWidth = labelWidth(hitText);
  const [leftRoom, rightRoom] = [labelTo - curve.left, curve.right - labelFrom];
  const labelLeft = rightRoom < hitWidth && leftRoom > rightRoom;
  const hitLabelY = y(model.hit) + 5;
  // Completely within the curve or above it, never across its upper edge.
  const overHit = y(model.hit) - 13;
  const windowTextY = overHit > curve.top + 11 ? overHit : curve.top - 3;
  const edgeTop = y(model.hit) + 12;
  const edgeHeight = Math.max(44, y0 - edgeTop);
  const edgeAt = edgeTop + edgeHeight / 2;
  // A short free part, as on a phone, may be narrower than the label, which would then cover the numbers of the axis.
  // If the window's arrow is as low as the label, the label ends before the arrow. It is below the handle, or above the
  // line of 0 if a strong hit leaves no room below.
  const belowMiss = Math.min(y(model.miss) + 24, curve.bottom - 6);
  const missLabelY = belowMiss > y(model.miss) + 16 ? belowMiss : Math.min(y0, y(model.miss)) - 11;
  const isBesideArrow = Math.abs(missLabelY - 5 - edgeAt) < 18;
  // In a low curve both labels may be left of the window, at the same height; the miss is then left of the hit.
  const isBesideHit = labelLeft && !noReturn && Math.abs(missLabelY - hitLabelY) < LABEL_HEIGHT;
  const hitRoom = Math.max(leftRoom, rightRoom) - (isBesideHit ? labelWidth(signed(model.miss)) + LABEL_GAP : 0);
  const hitLabel = hitRoom < hitWidth ? signed(model.hit) : hitText;
  const missEnd = Math.min(
    freeTo - (isBesideArrow ? ARROW : 0),
    isBesideHit ? labelTo - labelWidth(hitLabel) - LABEL_GAP : Number.POSITIVE_INFINITY,
  );
  const missLabel = missEnd - curve.left < labelWidth(missText) ? signed(model.miss) : missText;
  const missHalf = labelWidth(missLabel) / 2;
  const missLabelX = Math.max(Math.min((curve.left + freeTo) / 2, missEnd - missHalf), curve.left + missHalf);
  // A ramp has no steps. It is drawn from one side of the window to the other, negative and positive part apart.
  const widest = isRamp ? 2 * controls.bounds("sigma").high : controls.bounds("window").high / 2;
  const ramp = isRamp
    ? rampPoints(Math.max(0, z - half), z + half).map((s) => [x(s), increment(s, z, values)] as const)
    : [];
  const rampLine = ramp.map(([px, value]) => `L${px.toFixed(1)} ${y(value).toFixed(1)}`).join("");
  const rampArea = (part: (value: number) => number): string =>
    `M${hitFrom} ${y0}${ramp.map(([px, value]) => `L${px.toFixed(1)} ${y(part(value)).toFixed(1)}`).join("")}L${hitTo} ${y0}Z`;
  const line = noReturn
    ? `M${curve.left} ${frees ? y(model.miss) : y0}H${freeTo}V${y0}H${curve.right}`
    : isRamp
      ? `M${curve.left} ${freeTo > curve.left ? y(model.miss) : y0}H${freeTo}${rampLine}H${curve.right}`
      : `M${curve.left} ${freeTo > curve.left ? y(model.miss) : y(model.hit)}H${freeTo}V${y(model.hit)}H${hitTo}V${y0}H${curve.right}`;
  const rangeX = toPixel(values.range_max, xs);
  const rangeShown = rangeX >= curve.left && rangeX <= curve.right;

  return (
    <g>
      <rect
        class="zone-miss"
        x={curve.left}
        y={curve.top}
        width={freeTo - curve.left}
        height={curve.bottom - curve.top}
      />
      <rect class="zone-hit" x={hitFrom} y={curve.top} width={hitTo - hitFrom} height={curve.bottom - curve.top} />
      <rect class="zone-prior" x={hitTo} y={curve.top} width={curve.right - hitTo} height={curve.bottom - curve.top} />
      <Axes view={view} />
      {freeTo > curve.left && (
        <rect
          class="area-miss"
          x={curve.left}
          y={Math.min(y0, y(model.miss))}
          width={freeTo - curve.left}
          height={Math.abs(y(model.miss) - y0)}
        />
      )}
      {!noReturn && (
        <>
          {2 * half < values.resolution && (
            <rect
              class="endpoint-cell"
              x={x(cell)}
              y={y(model.hit)}
              width={x(cell + values.resolution) - x(cell)}
              height={y0 - y(model.hit)}
            />
          )}
          {isRamp ? (
            <>
              <path class="area-miss" d={rampArea((value) => Math.min(0, value))} />
              <path class="area-hit" d={rampArea((value) => Math.max(0, value))} />
            </>
          ) : (
            <rect class="area-hit" x={hitFrom} y={y(model.hit)} width={hitTo - hitFrom} height={y0 - y(model.hit)} />
          )}
        </>
      )}
      {rangeShown && <line class="range-line" x1={rangeX} x2={rangeX} y1={curve.top} y2={curve.bottom} />}
      {!noReturn && (
        // It begins below the window's label, whose centre is at the reading.
        <line class="reading-line" x1={zx} x2={zx} y1={low ? curve.top : windowTextY + 4} y2={strip.top} />
      )}
      <path class="profile-line" d={line} />
      {freeTo > curve.left && (
        <line class="profile-miss" x1={curve.left} x2={freeTo} y1={y(model.miss)} y2={y(model.miss)} />
      )}
      {!noReturn && !isRamp && (
        <line class="profile-hit" x1={hitFrom - 1.5} x2={hitTo + 1.5} y1={y(model.hit)} y2={y(model.hit)} />
      )}
      {curve.right - hitTo > (narrow ? 160 : 190) && (
        <text class="label-prior" x={curve.right - 10} y={low ? y0 + 17 : y0 - 9} text-anchor="end">
          {frees ? "beyond: no evidence" : "no evidence"}
        </text>
      )}

      {freeTo > curve.left + 30 && (
        <Handle
          label={NAMES[values.model]?.miss ?? "Miss increment"}
          sentence="Strength of the evidence that a cell before the reading is free."
          axis="y"
          tone="tone-miss"
          now={miss.value}
          low={miss.range.low}
          high={miss.range.high}
          text={missText}
          grab={{ x: curve.left, y: y(model.miss) - 20, width: Math.max(30, freeTo - curve.left - 46), height: 44 }}
          {...controls.level("miss")}
        >
          <rect
            class="handle-mark"
            x={(curve.left + freeTo) / 2 - 15}
            y={y(model.miss) - 5}
            width={30}
            height={10}
            rx={5}
          />
          <text class="label-miss" x={missLabelX} y={missLabelY} text-anchor="middle">
            {missLabel}
          </text>
        </Handle>
      )}
      {!noReturn && (
        <>
          <Handle
            label={NAMES[values.model]?.hit ?? "Hit increment"}
            sentence="Strength of the evidence that a cell at the reading is occupied."
            axis="y"
            tone="tone-hit"
            now={hit.value}
            low={hit.range.low}
            high={hit.range.high}
            text={hitText}
            grab={{
              x: Math.min(hitFrom, zx - 24),
              y: y(model.hit) - 32,
              width: Math.max(48, hitTo - hitFrom),
              height: 44,
            }}
            {...controls.level("hit")}
          >
            <rect
              class="handle-mark"
              x={(hitFrom + hitTo) / 2 - 15}
              y={y(model.hit) - 5}
              width={30}
              height={10}
              rx={5}
            />
            <text
              class="label-hit"
              x={labelLeft ? labelTo : labelFrom}
              y={hitLabelY}
              text-anchor={labelLeft ? "end" : "start"}
            >
              {hitLabel}
            </text>
          </Handle>
          <WindowEdges
            view={view}
            controls={controls}
            name={isRamp ? "ramp" : "hit window"}
            near={hitFrom}
            far={hitTo}
            y={edgeAt}
            top={edgeTop}
            height={edgeHeight}
            widest={widest}
          />
          <ReadingLabel view={view} controls={controls} x={zx} y={curve.bottom + 14} above={40} height={54} />
          {!low && (
            <text class="label-window" x={(hitFrom + hitTo) / 2} y={windowTextY} text-anchor="middle">
              {windowText}
            </text>
          )}
        </>
      )}
      {noReturn && (
        <text class="label-beam" x={curve.right - 10} y={curve.bottom + 18} text-anchor="end">
          {narrow ? "no return" : "no return: the beam found nothing within the max range"}
        </text>
      )}
      {rangeShown && <RangeMaxFlag view={view} controls={controls} on="curve" x={rangeX} y={curve.top} />}
    </g>
  );
}
