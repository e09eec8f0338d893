import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import { useDrag } from "../../ui/browser/useDrag";
import type { Point } from "../../wire/protocol";
import type { StageTransform } from "./Stage";

interface DragHandleProps {
  readonly transform: StageTransform;
  readonly at: Point;
  readonly label: string;
  /** One sentence on what it does. */
  readonly sentence: string;
  /** Its position in words. */
  readonly text: string;
  readonly tone?: "robot" | "beam" | "hit" | "miss" | "neutral";
  /** Metres that an arrow key moves it; a fifth of that with Shift. */
  readonly step: number;
  readonly onMove: (point: Point) => void;
  /** Called for arrow keys instead of `onMove`, for example to rotate. `by` is ±1 or ±0.2. */
  readonly onTurn?: (by: number) => void;
  /** Called when the handle is let go: at the end of a drag, and when the arrow key or the focus leaves it. */
  readonly onRelease?: () => void;
  readonly children?: ComponentChildren;
}

const DIRECTIONS: Record<string, Point> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/** A handle at a point of the world that moves in two directions, by mouse, touch or arrow keys. */
export function DragHandle({
  transform,
  at,
  label,
  sentence,
  text,
  tone = "robot",
  step,
  onMove,
  onTurn,
  onRelease,
  children,
}: DragHandleProps) {
  const id = useId();
  const [x, y] = [transform.x(at[0]), transform.y(at[1])];
  const drag = useDrag({
    begin: () => at,
    move: (from, dx, dy) => onMove([from[0] + dx / transform.metre, from[1] - dy / transform.metre]),
    end: onRelease,
  });
  return (
    <g
      class={`drag-handle tone-${tone}`}
      role="slider"
      tabindex={0}
      aria-label={label}
      aria-roledescription="handle that moves in two directions"
      aria-valuenow={Number(at[0].toFixed(3))}
      aria-valuemin={Number(transform.world(0, 0)[0].toFixed(3))}
      aria-valuemax={Number(transform.world(transform.width, 0)[0].toFixed(3))}
      aria-valuetext={text}
      aria-describedby={id}
      transform={`translate(${x} ${y})`}
      onClick={(event) => event.stopPropagation()}
      {...drag}
      onKeyUp={(event) => event.key in DIRECTIONS && onRelease?.()}
      onBlur={() => onRelease?.()}
      onKeyDown={(event) => {
        const direction = DIRECTIONS[event.key];
        if (!direction) return;
        event.preventDefault();
        const by = event.shiftKey ? 0.2 : 1;
        if (onTurn) onTurn(by * (direction[1] || -direction[0]));
        else onMove([at[0] + by * step * direction[0], at[1] + by * step * direction[1]]);
      }}
    >
      <desc id={id}>{sentence}</desc>
      <circle class="drag-handle-grab" r={22} />
      {children ?? <circle class="drag-handle-dot" r={9} />}
    </g>
  );
}

/** A robot seen from above, its heading along +x of its own frame. */
export function RobotShape({ yaw, size = 11 }: { yaw: number; size?: number }) {
  return (
    <g class="robot-shape" transform={`rotate(${(-yaw * 180) / Math.PI})`}>
      <circle r={size} />
      <path d={`M${size * 0.2} ${-size * 0.45}L${size * 0.75} 0L${size * 0.2} ${size * 0.45}`} />
    </g>
  );
}
