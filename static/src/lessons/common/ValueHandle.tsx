import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { Handle } from "../../ui/Handle";
import { keyed, type Range, snap } from "../../ui/numbers";

/** Share of the way of the pointer that the value moves while Shift is held. */
const FINE = 0.2;

interface ValueHandleProps {
  readonly label: string;
  /** One sentence on what it does. */
  readonly sentence: string;
  readonly axis: "x" | "y";
  readonly tone: string;
  readonly value: number;
  readonly range: Range;
  readonly text: string;
  /** The area where it can be grabbed: at least 40 × 40 px. */
  readonly grab: { readonly x: number; readonly y: number; readonly width: number; readonly height: number };
  /** By how much the value grows for each pixel to the right, or down. */
  readonly perPixel: number;
  readonly onValue: (value: number) => void;
  readonly children: ComponentChildren;
}

/** A handle in an SVG figure whose value is proportional to its way along one axis. */
export function ValueHandle({ axis, value, range, perPixel, onValue, ...rest }: ValueHandleProps) {
  const before = useRef(0);
  return (
    <Handle
      {...rest}
      axis={axis}
      now={value}
      low={range.low}
      high={range.high}
      onStart={() => {
        before.current = value;
      }}
      onDrag={(dx, dy, fine) => {
        const dragged = (fine ? FINE : 1) * (axis === "x" ? dx : dy);
        onValue(snap(before.current + dragged * perPixel, range));
      }}
      onKey={(key, shift) => {
        const next = keyed(key, shift, value, range);
        if (next !== null) onValue(next);
        return next !== null;
      }}
    />
  );
}
