import { evidenceScale, LogOddsBackground, readingScale, ZoneNames } from "../../render/chart/LogOddsBackground";
import { toPixel } from "../../render/chart/scale";
import { signed } from "../../ui/numbers";
import type { Rect } from "./camera";
import type { Scene, Shown } from "./scene";

interface LadderProps {
  readonly rect: Rect;
  readonly scene: Scene;
  readonly shown: Shown;
}

/** ℓ of the selected cell before the first scan and after each, up to the scan that is shown. */
export function Ladder({ rect, scene, shown }: LadderProps) {
  const { history, count, index } = shown;
  if (scene.bare)
    return (
      <g class="world-stage-ladder" transform={`translate(${rect.left} ${rect.top})`}>
        <rect class="world-stage-ladder-ground" width={rect.width} height={rect.height} />
        <text x={rect.width / 2} y={rect.height / 2} text-anchor="middle">
          A map of landmarks has no cells.
        </text>
      </g>
    );
  const path = scene.ladder ?? (index < 0 ? [0] : history.ladder(index).slice(0, count + 1));
  const limits = scene.config.clamp ? [scene.config.log_odds_min, scene.config.log_odds_max] : [];
  const up = evidenceScale(rect.height, limits, path);
  const across = readingScale(rect.width, 0, Math.max(10, scene.ladder ? 0 : scene.poses.length));
  const x = (i: number): number => toPixel(i, across);
  const y = (l: number): number => toPixel(l, up);
  const line = path.map((l, i) => (i === 0 ? `M${x(0)} ${y(l)}` : `H${x(i)}V${y(l)}`)).join("");
  const last = path.at(-1) ?? 0;
  return (
    <g class="world-stage-ladder" transform={`translate(${rect.left} ${rect.top})`}>
      <rect class="world-stage-ladder-ground" width={rect.width} height={rect.height} />
      <LogOddsBackground width={rect.width} evidence={up} limits={limits} />
      <path class="profile-line" d={line} />
      <ZoneNames width={rect.width} evidence={up} />
      <circle class="world-stage-ladder-now" cx={x(path.length - 1)} cy={y(last)} r={5} />
      <text class="world-stage-ladder-name" x={rect.width > 300 ? 44 : 0} y={-6}>
        {rect.width > 300 && (scene.ladder ? "visited cell: " : "marked cell: ")}ℓ = {signed(last)} after{" "}
        {path.length - 1} {path.length === 2 ? "scan" : "scans"}
      </text>
    </g>
  );
}
