import { useLayoutEffect, useRef } from "preact/hooks";
import { beamModel, halfWindow, increment, type SensorModelParameters } from "../../grid/sensorModel";
import { ticks, toPixel } from "../../render/chart/scale";
import { tokenRgb } from "../../style/colour";
import { isDark } from "../../ui/browser/theme";
import { Handle } from "../../ui/Handle";
import { signed, written } from "../../ui/numbers";
import type { Controls } from "./controls";
import type { Box } from "./layout";
import { DistanceTitle } from "./Strip";
import { ReadingLabel, WindowEdges } from "./sharedHandles";
import type { ProfileView } from "./view";

/** Cells narrower than this are painted in blocks, each with the increment at its centre, CSS pixels. */
const LEAST_PX = 3;
/** Position of the handle along the cone's edge, as a share of the reading. */
const HANDLE_AT = 0.72;

/** The box of the cone: the sensor at the left, the axis in the middle, the same scale in both directions. */
function placed(view: ProfileView): { readonly box: Box; readonly axis: number; readonly perMetre: number } {
  const { curve, strip } = view.layout.value;
  const box = { left: curve.left, right: curve.right, top: curve.top, bottom: strip.bottom };
  return { box, axis: (box.top + box.bottom) / 2, perMetre: (box.right - box.left) / view.reach.value };
}

/** Paint the cells of a grid around the cone's axis in the colours of their increments. */
function paintCells(canvas: HTMLCanvasElement, view: ProfileView, values: SensorModelParameters, z: number): void {
  const { box, perMetre } = placed(view);
  const ratio = devicePixelRatio;
  const width = box.right - box.left;
  const height = box.bottom - box.top;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const ctx = canvas.getContext("2d");
  if (!ctx) return;
  ctx.scale(ratio, ratio);
  const model = beamModel(values);
  const half = view.noReturn.peek() ? 0 : halfWindow(z, values);
  const reach = Math.min(view.noReturn.peek() ? values.range_max : z + half, values.range_max);
  const size = values.resolution * Math.max(1, Math.ceil(LEAST_PX / (values.resolution * perMetre)));
  const px = size * perMetre;
  const gap = px > 6 ? 1 : 0;
  const rows = Math.ceil(height / 2 / px);
  const cols = Math.ceil(width / px);
  const colours = { free: tokenRgb("--miss-fill"), hit: tokenRgb("--hit-fill"), none: tokenRgb("--prior-wash") };
  const paint = (rgb: readonly number[], alpha: number, row: number, col: number): void => {
    ctx.fillStyle = `rgb(${rgb[0]} ${rgb[1]} ${rgb[2]} / ${alpha})`;
    ctx.fillRect(col * px, height / 2 - (row + 0.5) * px, px - gap, px - gap);
  };
  for (let row = -rows; row <= rows; row++) {
    for (let col = 0; col < cols; col++) {
      const ahead = (col + 0.5) * size;
      const aside = row * size;
      const s = Math.hypot(ahead, aside);
      const gained = s <= reach ? increment(s, z, values, Math.atan2(aside, ahead)) : 0;
      if (gained === 0) {
        if (gap > 0) paint(colours.none, 1, row, col);
        continue;
      }
      const share = Math.abs(gained / (gained < 0 ? model.miss : model.hit));
      paint(gained < 0 ? colours.free : colours.hit, 0.12 + 0.88 * share, row, col);
    }
  }
}

/** The cells of the cone, on a canvas behind the handles. */
export function ConeCells({ view, scale }: { readonly view: ProfileView; readonly scale: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { box } = placed(view);
  const values = view.values.value;
  const z = view.z.value;
  const dark = isDark.value;
  useLayoutEffect(() => {
    if (canvas.current) paintCells(canvas.current, view, values, z);
  }, [view, values, z, dark, box.right, view.reach.value]);
  const style = {
    zoom: scale,
    left: `${box.left}px`,
    top: `${box.top}px`,
    width: `${box.right - box.left}px`,
    height: `${box.bottom - box.top}px`,
  };
  return (
    <canvas
      class="cone-cells"
      ref={canvas}
      style={style}
      role="img"
      aria-label="Cells of the cone, coloured by their increments"
    />
  );
}

/** A wide beam from above: its edges and its arc, with their handles. */
export function Cone({ view, controls }: { readonly view: ProfileView; readonly controls: Controls }) {
  const { box, axis, perMetre } = placed(view);
  const values = view.values.value;
  const z = view.z.value;
  const noReturn = view.noReturn.value;
  const model = beamModel(values);
  const scale = view.xScale.value;
  const x = (s: number): number => toPixel(s, scale);
  const half = halfWindow(z, values);
  const edge = values.opening / 2;
  const end = noReturn ? values.range_max : z + half;
  const at = (s: number, theta: number): readonly [number, number] => [
    box.left + s * perMetre * Math.cos(theta),
    axis - s * perMetre * Math.sin(theta),
  ];
  const arc = (s: number): string => {
    const radius = s * perMetre;
    return `M${at(s, -edge).join(" ")}A${radius} ${radius} 0 0 0 ${at(s, edge).join(" ")}`;
  };
  const [handleX, handleY] = at(HANDLE_AT * (noReturn ? Math.min(values.range_max, view.reach.value) : z), edge);
  const degrees = (values.opening * 180) / Math.PI;
  const certain = values.model === "moravec_elfes";
  const zx = x(z);
  const narrow = view.width.value < 560;
  return (
    <g>
      <path class="cone-edge" d={`M${at(end, edge).join(" ")}L${box.left} ${axis}L${at(end, -edge).join(" ")}`} />
      {!noReturn && <path class="cone-arc" d={arc(z)} />}
      {ticks(0, view.reach.value, narrow ? 4 : 8).map((tick) => (
        <text key={tick} class="tick" x={x(tick)} y={box.bottom + 31} text-anchor="middle">
          {written(tick, tick % 1 === 0 ? 0 : 1)}
        </text>
      ))}
      <DistanceTitle layout={view.layout.value} />
      <text class="label-miss" x={box.left + 12} y={box.top + 16}>
        {certain ? "empty: certainty up to 1" : `closer ${signed(model.miss)}`}
      </text>
      <text class="label-hit" x={box.right - 8} y={box.top + (narrow ? 36 : 16)} text-anchor="end">
        {certain
          ? `occupied: ${narrow ? "" : "one obstacle, "}somewhere on the arc`
          : `on the arc ${signed(model.hit)}`}
      </text>
      <Handle
        label="Opening angle"
        sentence="Changes the opening angle of the cone."
        axis="y"
        tone="tone-robot"
        now={values.opening}
        low={controls.bounds("opening").low}
        high={controls.bounds("opening").high}
        text={`${written(degrees, 0)} degrees`}
        grab={{ x: handleX - 22, y: handleY - 22, width: 44, height: 44 }}
        {...controls.opening(handleX - box.left, axis - handleY)}
      >
        <circle class="handle-mark" cx={handleX} cy={handleY} r={8} />
        <text class="label-robot" x={handleX} y={handleY - 14} text-anchor="middle">
          {`β ${written(degrees, 0)}°`}
        </text>
      </Handle>
      {!noReturn && (
        <>
          <WindowEdges
            view={view}
            controls={controls}
            name="arc"
            near={x(z - half)}
            far={x(z + half)}
            y={axis}
            top={axis - 22}
            height={44}
            widest={controls.bounds("window").high / 2}
          />
          <ReadingLabel view={view} controls={controls} x={zx} y={box.bottom + 2} above={24} height={48} />
        </>
      )}
      {noReturn && (
        <text class="label-beam" x={box.right - 10} y={box.bottom - 8} text-anchor="end">
          no return
        </text>
      )}
    </g>
  );
}
