/** The outline of the robot: a polygon whose corners one drags. */

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { zoomOf } from "../../ui/browser/zoom";
import { written } from "../../ui/numbers";
import { ROBOT_RADIUS } from "../../wire/constants";
import type { Point } from "../../wire/protocol";
import { OUTLINES, refusalOf, rounded } from "./footprint";
import { costmapOf } from "./state";

const SIZE = 190;
const STEP = 0.01;
const FARTHEST = 0.95;
const STEPS: Readonly<Record<string, Point>> = {
  ArrowLeft: [-STEP, 0],
  ArrowRight: [STEP, 0],
  ArrowUp: [0, STEP],
  ArrowDown: [0, -STEP],
};

export function Outline({ store }: { readonly store: Store }) {
  const costmap = costmapOf(store).costmap.value;
  const sketch = useSignal<readonly Point[] | null>(null);
  const refused = useSignal<string | null>(null);
  const held = useRef<{ corner: number; at: Point; from: Point } | null>(null);
  if (!costmap) return null;
  const corners = sketch.value ?? costmap.footprint;
  const farthest = Math.max(0.3, ...costmap.footprint.flat().map(Math.abs));
  const scale = (SIZE / 2 - 16) / farthest;
  const at = ([x, y]: Point): Point => [SIZE / 2 + scale * x, SIZE / 2 - scale * y];
  const move = (corner: number, to: Point): void => {
    const inside = to.map((v) => rounded(Math.min(FARTHEST, Math.max(-FARTHEST, v)))) as unknown as Point;
    const next = corners.map((one, i) => (i === corner ? inside : one));
    refused.value = refusalOf(next);
    if (held.current) sketch.value = next;
    if (refused.value === null) costmapOf(store).setFootprint(next);
  };
  const release = (): void => {
    held.current = null;
    sketch.value = null;
  };
  return (
    <figure class="outline" aria-label="Outline of the robot, seen from above">
      <svg role="presentation" width={SIZE} height={SIZE}>
        <circle class="body" cx={SIZE / 2} cy={SIZE / 2} r={scale * ROBOT_RADIUS} />
        <circle class="circumscribed" cx={SIZE / 2} cy={SIZE / 2} r={scale * costmap.circumscribed_radius} />
        <circle class="inscribed" cx={SIZE / 2} cy={SIZE / 2} r={scale * costmap.inscribed_radius} />
        <polygon
          class={refused.value ? "shape refused" : "shape"}
          points={corners.map((corner) => at(corner).join(",")).join(" ")}
        />
        <path class="heading" d={`M${SIZE / 2} ${SIZE / 2}h${scale * ROBOT_RADIUS}`} />
        {corners.map((corner, n) => {
          const [x, y] = at(corner);
          return (
            // biome-ignore lint/a11y/useSemanticElements: SVG has no buttons
            <g
              key={n}
              class="handle corner"
              role="button"
              tabindex={0}
              aria-label={`Corner ${n + 1} of ${corners.length}: ${written(corner[0], 2)} m ahead, ${written(corner[1], 2)} m to the left; arrow keys move it`}
              onPointerDown={(event) => {
                if (event.button !== 0) return;
                event.preventDefault();
                event.currentTarget.focus({ preventScroll: true });
                event.currentTarget.setPointerCapture(event.pointerId);
                held.current = { corner: n, at: [event.clientX, event.clientY], from: corner };
              }}
              onPointerMove={(event) => {
                const now = held.current;
                if (!now) return;
                const px = scale * zoomOf(event.currentTarget);
                const [dx, dy] = [(event.clientX - now.at[0]) / px, (event.clientY - now.at[1]) / px];
                move(now.corner, [now.from[0] + dx, now.from[1] - dy]);
              }}
              onPointerUp={release}
              onPointerCancel={release}
              onKeyDown={(event) => {
                const step = STEPS[event.key];
                if (!step) return;
                event.preventDefault();
                move(n, [corner[0] + step[0], corner[1] + step[1]]);
              }}
            >
              <rect class="handle-grab" x={x - 16} y={y - 16} width={32} height={32} />
              <circle class="handle-mark" cx={x} cy={y} r={6} />
            </g>
          );
        })}
      </svg>
      <figcaption>
        <p>Drag the corners of the robot’s outline.</p>
        <div class="actions">
          {OUTLINES.map((one) => (
            <button
              key={one.label}
              type="button"
              class="button"
              onClick={() => {
                refused.value = null;
                costmapOf(store).setFootprint(one.corners);
              }}
            >
              {one.label}
            </button>
          ))}
        </div>
        <p class="navigation-refused" role="status">
          {refused.value}
        </p>
      </figcaption>
    </figure>
  );
}
