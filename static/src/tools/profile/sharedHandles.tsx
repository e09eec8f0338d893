/** Handles that are used in several parts of the figure: on the curve, on the cone, on the whole beam. */

import { halfWindow } from "../../grid/sensorModel";
import { Handle } from "../../ui/Handle";
import { written } from "../../ui/numbers";
import type { Controls } from "./controls";
import type { ProfileView } from "./view";

interface SharedHandleProps {
  readonly view: ProfileView;
  readonly controls: Controls;
}

/** Name of the window in the current model. */
type WindowName = "hit window" | "ramp" | "arc";

interface WindowEdgesProps extends SharedHandleProps {
  readonly name: WindowName;
  /** Positions of the two edges and of the middle of their arrows; pixels. */
  readonly near: number;
  readonly far: number;
  readonly y: number;
  readonly top: number;
  readonly height: number;
  /** Greatest distance of an edge from the reading, metres. */
  readonly widest: number;
}

/** Handles of the two edges of the window around the reading; the window stays symmetric. */
export function WindowEdges({ view, controls, name, near, far, y, top, height, widest }: WindowEdgesProps) {
  const z = view.z.value;
  const half = halfWindow(z, view.values.value);
  return (
    <>
      {(["near", "far"] as const).map((side) => {
        const at = side === "near" ? near : far;
        const out = side === "near" ? -1 : 1;
        return (
          <Handle
            key={side}
            label={`${side === "near" ? "Near" : "Far"} edge of the ${name}`}
            sentence={`Changes the width of the ${name} around the reading; the other edge follows.`}
            axis="x"
            tone="tone-hit"
            now={z + out * half}
            low={side === "near" ? z - widest : z}
            high={side === "near" ? z : z + widest}
            text={`${name === "arc" ? "arc" : "window"} ${written(2 * half, 2)} metres ${name === "arc" ? "thick" : "wide"}`}
            grab={{ x: side === "near" ? at - 40 : at - 4, y: top, width: 44, height }}
            {...controls.edge(side)}
          >
            <path class="handle-mark" d={`M${at + out * 4} ${y - 11}l${out * 11} 11l${-out * 11} 11z`} />
          </Handle>
        );
      })}
    </>
  );
}

interface ReadingLabelProps extends SharedHandleProps {
  readonly x: number;
  /** The middle of the label, and the draggable area around it. */
  readonly y: number;
  readonly above: number;
  readonly height: number;
}

/** The reading z as a label on the axis. */
export function ReadingLabel({ view, controls, x, y, above, height }: ReadingLabelProps) {
  const z = view.z.value;
  return (
    <Handle
      label="Measured range z"
      sentence="Moves the reading; the curve, the cells and the text follow."
      axis="x"
      tone="tone-beam"
      now={z}
      low={0}
      high={view.total.value}
      text={`${written(z, 2)} metres`}
      grab={{ x: x - 26, y: y - above, width: 52, height }}
      {...controls.reading("curve")}
    >
      <rect class="pill" x={x - 38} y={y - 11} width={76} height={22} rx={11} />
      <text class="label-pill" x={x} y={y + 4} text-anchor="middle">
        {`z ${written(z, 2)} m`}
      </text>
    </Handle>
  );
}

interface RangeMaxFlagProps extends SharedHandleProps {
  readonly on: "beam" | "curve";
  readonly x: number;
  /** The flag's upper edge. */
  readonly y: number;
  /** The lower end of its line, if it has one. */
  readonly down?: number;
  readonly label?: { readonly x: number; readonly anchor: "start" | "end" };
}

/** The max range as a flag. */
export function RangeMaxFlag({ view, controls, on, x, y, down, label }: RangeMaxFlagProps) {
  const { range_max } = view.values.value;
  const { low, high } = controls.bounds("range_max");
  const text = written(range_max, 1);
  return (
    <Handle
      label={on === "beam" ? "Max range" : "Max range, on the curve"}
      sentence="Readings beyond the max range count as no return."
      axis="x"
      tone="tone-range"
      now={range_max}
      low={low}
      high={high}
      text={`${text} metres`}
      grab={{ x: x - 22, y: y - 10, width: 44, height: 44 }}
      {...controls.rangeMax(on)}
    >
      {down !== undefined && <line class="range-line" x1={x} x2={x} y1={y + 8} y2={down} />}
      <path class="handle-mark" d={`M${x - 7} ${y}h14v8l-7 7l-7 -7z`} />
      {label && (
        <text class="label-range" x={label.x} y={y + 10} text-anchor={label.anchor}>{`max range ${text} m`}</text>
      )}
    </Handle>
  );
}
