import { useRef } from "preact/hooks";
import { linePath, ticks } from "../../render/chart/scale";
import { useDrawing } from "../../ui/browser/useDrawing";
import type { Forgetting } from "../../wire/protocol";
import type { Point } from "./model";

const HEIGHT = 184;
const LEFT = 58;
const RIGHT = 12;
const BOTTOM = HEIGHT - 40;
const TOP = 18;
/** Share of the table's cells that have to be free, as the mapper counts it. */
const FORGOTTEN = 0.9;
const TICK_PX = 80;

interface ForgettingChartProps {
  readonly points: readonly Point[];
  readonly guess: number;
  readonly forgetting: Forgetting | null;
}

/** The share of the table's cells that are free in each map, over the scans since its removal; the guess as a line. */
export function ForgettingChart({ points, guess, forgetting }: ForgettingChartProps) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 560).value;
  const right = width - RIGHT;
  const last = points.at(-1)?.scans ?? 0;
  const most = Math.max(20, guess * 1.15, last * 1.05, (forgetting?.without_clamp ?? 0) * 1.15);
  const x = (scans: number): number => LEFT + (scans / most) * (right - LEFT);
  const y = (share: number): number => BOTTOM - share * (BOTTOM - TOP);
  const path = (share: (point: Point) => number): string =>
    linePath(points.map((point) => [x(point.scans), y(share(point))]));
  return (
    <div class="table-chart" ref={box} style={{ height: `${scale * HEIGHT}px` }}>
      <svg
        class="drawing"
        style={{ zoom: scale }}
        width={width}
        height={HEIGHT}
        role="img"
        aria-label="Share of the table’s cells that are free, over the scans since it was removed"
      >
        {[0, 0.5, 1].map((share) => (
          <g key={share} class="tick">
            <line x1={LEFT} x2={right} y1={y(share)} y2={y(share)} />
            <text x={LEFT - 6} y={y(share) + 4} text-anchor="end">
              {share * 100} %
            </text>
          </g>
        ))}
        <line class="most" x1={LEFT} x2={right} y1={y(FORGOTTEN)} y2={y(FORGOTTEN)} />
        <text x={LEFT + 20} y={y(FORGOTTEN) + 14}>
          forgotten: {100 * FORGOTTEN} % free
        </text>
        {ticks(0, most, width / TICK_PX).map((tick) => (
          <text key={tick} class="tick" x={x(tick)} y={BOTTOM + 17} text-anchor="middle">
            {tick}
          </text>
        ))}
        <text x={(LEFT + right) / 2} y={HEIGHT - 6} text-anchor="middle">
          scans since the table was removed
        </text>
        <text transform={`translate(12 ${(TOP + BOTTOM) / 2}) rotate(-90)`} text-anchor="middle">
          its cells that are free
        </text>
        <line class="guess" x1={x(guess)} x2={x(guess)} y1={TOP - 6} y2={BOTTOM} />
        <path class="free" d={path((point) => point.without)} />
        <path class="clamped" d={path((point) => point.withClamp)} />
      </svg>
    </div>
  );
}
