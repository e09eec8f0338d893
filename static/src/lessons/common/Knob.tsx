import type { ComponentChildren } from "preact";
import { useId, useRef } from "preact/hooks";
import type { Point } from "../../wire/protocol";
import type { Place } from "./Stage";

interface KnobProps {
  readonly place: Place;
  readonly at: Point;
  readonly label: string;
  /** One sentence on what it does. */
  readonly sentence: string;
  /** Where it is, in words. */
  readonly text: string;
  readonly tone?: "robot" | "beam" | "hit" | "miss" | "ink";
  /** Metres that an arrow key moves it; a fifth of that with Shift. */
  readonly step: number;
  readonly onMove: (point: Point) => void;
  /** Instead of moving it by arrow keys, something else: turning, for example. `by` is ±1 or ±0.2. */
  readonly onTurn?: (by: number) => void;
  readonly children?: ComponentChildren;
}

const WAYS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** A thing in the world that a mouse, a finger or the arrow keys can move. */
export function Knob({ place, at, label, sentence, text, tone = "robot", step, onMove, onTurn, children }: KnobProps) {
  const id = useId();
  const grip = useRef<{ readonly px: Point; readonly from: Point } | null>(null);
  const [x, y] = [place.x(at[0]), place.y(at[1])];
  const end = (): void => {
    grip.current = null;
  };
  return (
    <g
      class={`knob-handle tone-${tone}`}
      role="slider"
      tabindex={0}
      aria-label={label}
      aria-roledescription="handle that moves in two directions"
      aria-valuenow={Number(at[0].toFixed(3))}
      aria-valuemin={Number(place.world(0, 0)[0].toFixed(3))}
      aria-valuemax={Number(place.world(place.width, 0)[0].toFixed(3))}
      aria-valuetext={text}
      aria-describedby={id}
      transform={`translate(${x} ${y})`}
      onClick={(event) => event.stopPropagation()}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.preventDefault();
        event.currentTarget.focus({ preventScroll: true });
        event.currentTarget.setPointerCapture(event.pointerId);
        grip.current = { px: [event.clientX, event.clientY], from: at };
      }}
      onPointerMove={(event) => {
        const held = grip.current;
        if (!held) return;
        const [dx, dy] = [event.clientX - held.px[0], event.clientY - held.px[1]];
        onMove([held.from[0] + dx / place.metre, held.from[1] - dy / place.metre]);
      }}
      onPointerUp={end}
      onPointerCancel={end}
      onLostPointerCapture={end}
      onKeyDown={(event) => {
        const way = WAYS[event.key];
        if (!way) return;
        event.preventDefault();
        const by = event.shiftKey ? 0.2 : 1;
        if (onTurn) onTurn(by * (way[1] || -way[0]));
        else onMove([at[0] + by * step * way[0], at[1] + by * step * way[1]]);
      }}
    >
      <desc id={id}>{sentence}</desc>
      <circle class="knob-grab" r={22} />
      {children ?? <circle class="knob-dot" r={9} />}
    </g>
  );
}

/** A robot seen from above, its nose along +x of its own frame. */
export function RobotShape({ yaw, size = 11 }: { yaw: number; size?: number }) {
  return (
    <g class="robot-shape" transform={`rotate(${(-yaw * 180) / Math.PI})`}>
      <circle r={size} />
      <path d={`M${size * 0.2} ${-size * 0.45}L${size * 0.75} 0L${size * 0.2} ${size * 0.45}`} />
    </g>
  );
}
