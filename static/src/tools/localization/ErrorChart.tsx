import { useRef } from "preact/hooks";
import { linePath, ticks } from "../../render/chart/scale";
import { useDrawing } from "../../ui/browser/useDrawing";
import type { Point } from "./model";

const HEIGHT = 150;
const LEFT = 46;
const RIGHT = 46;
const TOP = 16;
const BOTTOM = HEIGHT - 36;
const TICK_PX = 90;

/** The error of the estimate and the entropy of the particles, over the scans that were used. */
export function ErrorChart({ points }: { readonly points: readonly Point[] }) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 420).value;
  const right = width - RIGHT;
  const first = points[0]?.updates ?? 0;
  const last = Math.max(points.at(-1)?.updates ?? 0, first + 20);
  const metres = Math.max(1, ...points.map(({ error }) => error));
  const bits = Math.max(4, ...points.map(({ entropy }) => entropy));
  const x = (updates: number): number => LEFT + ((updates - first) / (last - first)) * (right - LEFT);
  const y = (share: number): number => BOTTOM - share * (BOTTOM - TOP);
  const path = (share: (point: Point) => number): string =>
    linePath(points.map((point) => [x(point.updates), y(share(point))]));
  return (
    <div class="localization-chart" ref={box} style={{ height: `${scale * HEIGHT}px` }}>
      <svg
        class="drawing"
        style={{ zoom: scale }}
        width={width}
        height={HEIGHT}
        role="img"
        aria-label="Error of the estimate and entropy of the particles, over the scans that were used"
      >
        <line class="axis" x1={LEFT} x2={right} y1={BOTTOM} y2={BOTTOM} />
        <text x={LEFT - 6} y={TOP + 4} text-anchor="end">
          {metres.toFixed(metres < 10 ? 1 : 0)} m
        </text>
        <text x={LEFT - 6} y={BOTTOM + 4} text-anchor="end">
          0
        </text>
        <text x={right + 6} y={TOP + 4}>
          {bits.toFixed(0)} bit
        </text>
        {ticks(first, last, width / TICK_PX).map((tick) => (
          <text key={tick} x={x(tick)} y={BOTTOM + 16} text-anchor="middle">
            {tick}
          </text>
        ))}
        <text x={(LEFT + right) / 2} y={HEIGHT - 4} text-anchor="middle">
          scans used
        </text>
        <path class="entropy" d={path((point) => point.entropy / bits)} />
        <path class="error" d={path((point) => point.error / metres)} />
      </svg>
    </div>
  );
}
