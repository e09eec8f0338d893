import { useId } from "preact/hooks";
import {
  beamModel,
  cellIncrement,
  cellIndexAt,
  cellZone,
  hitCells,
  isStepped,
  type Zone,
} from "../../grid/sensorModel";
import { ticks, toPixel } from "../../render/chart/scale";
import { keyed, signed, written } from "../../ui/numbers";
import type { Layout } from "./layout";
import type { ProfileView } from "./view";

const ZONES: readonly Zone[] = ["free", "hit", "beyond"];
const CLASS: Record<Zone, string> = { free: "cells-miss", hit: "cells-hit", beyond: "cells-prior" };

/** The same beam on a row of cells, each in the colour of its evidence. */
export function Strip({ view }: { view: ProfileView }) {
  const id = useId();
  const { strip, curve } = view.layout.value;
  const values = view.values.value;
  const z = view.z.value;
  const scale = view.xScale.value;
  const { resolution } = values;
  const model = beamModel(values);
  const x = (s: number): number => toPixel(s, scale);
  const size = x(resolution) - x(0);
  const gap = size > 6 ? 1 : 0;
  const first = Math.max(0, cellIndexAt(scale.low, resolution));
  const last = cellIndexAt(scale.high - 1e-9, resolution);
  const paths: Record<Zone, string> = { free: "", hit: "", beyond: "" };
  // If the cells of a zone get different increments, the opacity of each shows its own.
  const shades: { readonly d: string; readonly zone: Zone; readonly share: number }[] = [];
  for (let index = first; index <= last; index++) {
    const left = Math.max(strip.left, x(index * resolution));
    const right = Math.min(strip.right, x((index + 1) * resolution));
    const d = `M${left.toFixed(1)} ${strip.top}H${(right - gap).toFixed(1)}V${strip.bottom}H${left.toFixed(1)}Z`;
    const gained = cellIncrement(index, z, values);
    const zone = cellZone(index, z, values);
    if (isStepped(values) || zone !== "hit") paths[zone] += d;
    else {
      paths.beyond += d;
      const most = gained < 0 ? model.miss : model.hit;
      shades.push({ d, zone: gained < 0 ? "free" : "hit", share: most === 0 ? 0 : gained / most });
    }
  }
  const hovered = view.hovered.value;
  const marked = hovered !== null && hovered >= first && hovered <= last ? hovered : null;
  const inWindow = hitCells(z, values);
  const passed = inWindow
    ? inWindow[0]
    : values.no_return === "free" && view.noReturn.value
      ? cellIndexAt(values.range_max, resolution) + 1
      : 0;
  const hitCount = inWindow ? inWindow[1] - inWindow[0] + 1 : 0;
  const hitMiddle = inWindow ? x(((inWindow[0] + inWindow[1] + 1) * resolution) / 2) : x(values.range_max);
  const room = inWindow ? Math.max((hitCount * size) / 2, 46) + 10 : 12;
  const narrow = view.width.value < 560;
  const places = ticks(scale.low, scale.high, narrow ? 4 : 8);

  return (
    <g>
      {ZONES.map((zone) => (
        <path key={zone} class={CLASS[zone]} d={paths[zone]} />
      ))}
      {shades.map(({ d, zone, share }) => (
        <path key={d} class={CLASS[zone]} d={d} style={{ fillOpacity: share, strokeOpacity: share }} />
      ))}
      {marked !== null && (
        <g class="cell-marked">
          <rect
            class="cell-beam"
            x={x(marked * resolution)}
            y={curve.top}
            width={size}
            height={curve.bottom - curve.top}
          />
          <rect
            x={x(marked * resolution) - 0.5}
            y={strip.top - 1.5}
            width={size}
            height={strip.bottom - strip.top + 3}
          />
        </g>
      )}
      {passed > 0 && hitMiddle - room - strip.left > 60 && (
        <text class="label-miss" x={Math.min(hitMiddle - room, strip.right)} y={strip.bottom + 16} text-anchor="end">
          {narrow || hitMiddle - room - strip.left < 190
            ? `${passed} × ${signed(model.miss)}`
            : `${passed} cells passed, each ${signed(model.miss)}`}
        </text>
      )}
      {hitCount > 0 && (
        <text class="label-hit" x={hitMiddle} y={strip.bottom + 16} text-anchor="middle">
          {!isStepped(values)
            ? `up to ${signed(model.hit)}`
            : narrow || hitCount * size < 150
              ? `${hitCount} × ${signed(model.hit)}`
              : `${hitCount} cells hit, each ${signed(model.hit)}`}
        </text>
      )}
      {strip.right - hitMiddle - room > 70 && (
        <text class="label-prior" x={hitMiddle + room} y={strip.bottom + 16} text-anchor="start">
          untouched
        </text>
      )}
      {places.map((tick) => (
        <text key={tick} class="tick" x={x(tick)} y={strip.bottom + 31} text-anchor="middle">
          {written(tick, decimalsOf(places))}
        </text>
      ))}
      <DistanceTitle layout={view.layout.value} />
      <desc id={id}>Steps along the beam cell by cell and shows the increment of each cell.</desc>
      <rect
        class="strip-cursor"
        role="slider"
        tabindex={0}
        aria-label="Cell along the beam"
        aria-describedby={id}
        aria-valuemin={first}
        aria-valuemax={last}
        aria-valuenow={marked ?? cellIndexAt(z, resolution)}
        aria-valuetext={cellText(marked ?? cellIndexAt(Number.isFinite(z) ? z : values.range_max, resolution), view)}
        x={strip.left}
        y={strip.top - 4}
        width={strip.right - strip.left}
        height={strip.bottom - strip.top + 14}
        onKeyDown={(event) => {
          const now = marked ?? Math.min(last, cellIndexAt(Number.isFinite(z) ? z : values.range_max, resolution));
          const next = keyed(event.key, false, now, { low: first, high: last, step: 1 });
          if (next === null) return;
          event.preventDefault();
          view.hovered.value = next;
        }}
        onBlur={() => {
          view.hovered.value = null;
        }}
      />
    </g>
  );
}

/** The title of the distance axis: under its ticks if there is room, otherwise at its end. */
export function DistanceTitle({ layout }: { layout: Layout }) {
  const { strip, height, width } = layout;
  return height - strip.bottom > 50 ? (
    <text class="axis-title" x={(strip.left + strip.right) / 2} y={strip.bottom + 50} text-anchor="middle">
      distance r along the beam (m)
    </text>
  ) : (
    <text class="axis-title" x={width - 2} y={strip.bottom + 31} text-anchor="end">
      r (m)
    </text>
  );
}

function decimalsOf(places: readonly number[]): number {
  return places.some((place) => Math.abs(place * 10 - Math.round(place * 10)) > 1e-6)
    ? 2
    : places.some((p) => p % 1 !== 0)
      ? 1
      : 0;
}

const WHERE: Record<Zone, string> = { free: "passed", hit: "hit", beyond: "beyond, untouched" };

/** A cell in words: its extent and its increment. */
export function cellText(index: number, view: ProfileView): string {
  const values = view.values.value;
  const zone = cellZone(index, view.z.value, values);
  const from = index * values.resolution;
  const gained = cellIncrement(index, view.z.value, values);
  return `cell ${index}, ${written(from, 2)}–${written(from + values.resolution, 2)} m: ${WHERE[zone]}, ${zone === "beyond" ? "±0" : signed(gained)}`;
}
