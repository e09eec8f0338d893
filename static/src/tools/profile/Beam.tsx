import { halfWindow } from "../../grid/sensorModel";
import { ticks, toPixel } from "../../render/chart/scale";
import { Handle } from "../../ui/Handle";
import { written } from "../../ui/numbers";
import type { Controls } from "./controls";
import { RangeMaxFlag } from "./sharedHandles";
import type { ProfileView } from "./view";

/** The whole beam, to scale: the sensor, the reading, the max range, and the part that is enlarged below. */
export function Beam({ view, controls }: { view: ProfileView; controls: Controls }) {
  const { beam, curve } = view.layout.value;
  const scale = view.beamScale.value;
  const values = view.values.value;
  const z = view.z.value;
  const noReturn = view.noReturn.value;
  const { low: start, high } = view.xScale.value;
  const span = high - start;
  const x = (s: number): number => toPixel(s, scale);
  const middle = (beam.top + beam.bottom) / 2;
  const end = noReturn ? values.range_max : z;
  const half = halfWindow(noReturn ? values.range_max : z, values);
  const freeTo = noReturn ? (values.no_return === "free" ? values.range_max : 0) : Math.max(0, z - half);
  const handleX = Math.min(x(noReturn ? Math.min(z, view.total.value) : z), beam.right);
  const rangeX = Math.min(x(values.range_max), beam.right);
  const lensLeft = x(start);
  const lensRight = Math.max(x(start + span), lensLeft + 3);
  const labelEnd = rangeX > view.width.value - 132;

  return (
    <g>
      <polygon
        class="lens-cone"
        points={`${lensLeft},${beam.bottom - 4} ${lensRight},${beam.bottom - 4} ${curve.right},${curve.top - 12} ${curve.left},${curve.top - 12}`}
      />
      <line class="beam-axis" x1={beam.left} x2={beam.right} y1={middle} y2={middle} />
      <line class="beam-line" x1={beam.left} x2={x(Math.min(end, view.total.value))} y1={middle} y2={middle} />
      {freeTo > 0 && <rect class="fill-miss" x={beam.left} y={middle - 5} width={x(freeTo) - beam.left} height={10} />}
      {!noReturn && (
        <rect
          class="fill-hit"
          x={x(Math.max(0, z - half)) - 1}
          y={middle - 9}
          width={Math.max(3, x(z + half) - x(Math.max(0, z - half)))}
          height={18}
        />
      )}
      <rect
        class="lens-frame"
        x={lensLeft}
        y={beam.top - 2}
        width={lensRight - lensLeft}
        height={beam.bottom - beam.top}
        rx={3}
      />
      <path
        class="robot"
        d={`M${beam.left - 16} ${middle - 9}L${beam.left} ${middle}L${beam.left - 16} ${middle + 9}Z`}
      />
      {ticks(0, view.total.value, view.width.value < 560 ? 4 : 8).map((tick) => (
        <g key={tick} class="tick">
          <line x1={x(tick)} x2={x(tick)} y1={beam.bottom} y2={beam.bottom + 4} />
          <text x={x(tick)} y={beam.bottom + 16} text-anchor="middle">
            {`${written(tick, tick % 1 === 0 ? 0 : 1)}${tick === 0 ? " m" : ""}`}
          </text>
        </g>
      ))}
      <text class="axis-title" x={beam.left - 16} y={beam.top - 5}>
        {view.width.value < 430 ? "beam" : "the whole beam"}
      </text>
      <RangeMaxFlag
        view={view}
        controls={controls}
        on="beam"
        x={rangeX}
        y={beam.top - 18}
        down={beam.bottom}
        label={labelEnd ? { x: rangeX - 12, anchor: "end" } : { x: rangeX + 12, anchor: "start" }}
      />
      <Handle
        label="Measured range z, on the whole beam"
        sentence="Moves the reading along the whole beam; the enlarged part follows."
        axis="x"
        tone="tone-beam"
        now={noReturn ? values.range_max : z}
        low={0}
        high={view.total.value}
        text={noReturn ? "no return" : `${written(z, 2)} metres`}
        grab={{ x: handleX - 22, y: middle - 8, width: 44, height: 40 }}
        {...controls.reading("beam")}
      >
        <circle class="handle-mark" cx={handleX} cy={middle} r={8} />
      </Handle>
    </g>
  );
}
