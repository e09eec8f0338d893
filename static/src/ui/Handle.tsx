import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import { useDrag } from "./browser/useDrag";
import "./handle.css";

interface HandleProps {
  readonly label: string;
  /** One sentence on what it does. */
  readonly sentence: string;
  readonly now: number;
  readonly low: number;
  readonly high: number;
  readonly text: string;
  readonly axis: "x" | "y";
  readonly tone: string;
  /** The area where it can be grabbed: at least 40 × 40 px. */
  readonly grab: { readonly x: number; readonly y: number; readonly width: number; readonly height: number };
  readonly onStart: () => void;
  /** Pixels from where it was grabbed; `fine` while Shift is held. */
  readonly onDrag: (dx: number, dy: number, fine: boolean) => void;
  readonly onEnd?: () => void;
  readonly onKey: (key: string, shift: boolean) => boolean;
  readonly children: ComponentChildren;
}

/** A handle in an SVG figure that moves along one axis, by mouse, touch or keys. */
export function Handle(props: HandleProps) {
  const id = useId();
  const drag = useDrag({
    begin: props.onStart,
    move: (_, dx, dy, fine) => props.onDrag(dx, dy, fine),
    end: props.onEnd,
  });
  return (
    <g
      class={`handle ${props.tone}`}
      role="slider"
      tabindex={0}
      aria-label={props.label}
      aria-valuenow={Number(props.now.toFixed(4))}
      aria-valuemin={props.low}
      aria-valuemax={props.high}
      aria-valuetext={props.text}
      aria-describedby={id}
      aria-orientation={props.axis === "x" ? "horizontal" : "vertical"}
      data-axis={props.axis}
      {...drag}
      onKeyDown={(event) => {
        if (props.onKey(event.key, event.shiftKey)) event.preventDefault();
      }}
    >
      <desc id={id}>{props.sentence}</desc>
      <rect class="handle-grab" {...props.grab} />
      {props.children}
    </g>
  );
}
