import type { Forgetting } from "../../protocol";
import type { Point } from "./model";

const WIDTH = 560;
const HEIGHT = 150;
const LEFT = 40;
const BOTTOM = HEIGHT - 24;
const TOP = 12;

interface ForgottenProps {
  readonly points: readonly Point[];
  readonly guess: number;
  readonly told: Forgetting | null;
}

/** The share of the table's cells that each map holds free, over the scans since it went; the guess as a line. */
export function Forgotten({ points, guess, told }: ForgottenProps) {
  const last = points.at(-1)?.scans ?? 0;
  const most = Math.max(20, guess * 1.15, last * 1.05, (told?.without_clamp ?? 0) * 1.15);
  const x = (scans: number): number => LEFT + (scans / most) * (WIDTH - LEFT - 8);
  const y = (share: number): number => BOTTOM - share * (BOTTOM - TOP);
  const path = (share: (point: Point) => number): string =>
    `M${x(0)} ${y(0)}${points.map((point) => `L${x(point.scans).toFixed(1)} ${y(share(point)).toFixed(1)}`).join("")}`;
  const step = most > 120 ? 50 : most > 50 ? 20 : 10;
  const ticks = Array.from({ length: Math.floor(most / step) + 1 }, (_, i) => i * step);
  return (
    <svg
      class="table-chart"
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      role="img"
      aria-label="Share of the table's cells that are free, over the scans since it went"
    >
      {[0, 0.5, 1].map((share) => (
        <g key={share} class="tick">
          <line x1={LEFT} x2={WIDTH - 8} y1={y(share)} y2={y(share)} />
          <text x={LEFT - 6} y={y(share) + 4} text-anchor="end">
            {share * 100} %
          </text>
        </g>
      ))}
      <line class="most" x1={LEFT} x2={WIDTH - 8} y1={y(0.9)} y2={y(0.9)} />
      {ticks.map((tick) => (
        <text key={tick} class="tick" x={x(tick)} y={HEIGHT - 6} text-anchor="middle">
          {tick}
          {tick === 0 ? " scans" : ""}
        </text>
      ))}
      <line class="guess" x1={x(guess)} x2={x(guess)} y1={TOP - 6} y2={BOTTOM} />
      <path class="free" d={path((point) => point.without)} />
      <path class="clamped" d={path((point) => point.withClamp)} />
    </svg>
  );
}
