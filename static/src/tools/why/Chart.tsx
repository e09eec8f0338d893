import type { ReadonlySignal } from "@preact/signals";
import {
  evidenceScale,
  LogOddsBackground,
  ReadingTitle,
  readingScale,
  TITLE_PX,
  ZoneNames,
} from "../../render/chart/LogOddsBackground";
import { toPixel, toValue } from "../../render/chart/scale";
import type { Contribution, WhyMessage } from "../../wire/protocol";
import { logOddsCurve } from "./model";

const WIDTH = 400;
const HEIGHT = 150;
/** Updates that are closer than this are marked at the edges instead of on the line. */
const ROOMY_PX = 7;

interface ChartProps {
  readonly why: WhyMessage;
  readonly selected: ReadonlySignal<Contribution | null>;
  readonly onSelect: (n: number) => void;
}

/** The log-odds of one cell over its updates; the pointer selects one. */
export function Chart({ why, selected, onSelect }: ChartProps) {
  const curve = logOddsCurve(why);
  const limits = [why.log_odds_min, why.log_odds_max].filter((limit) => limit !== null);
  const across = readingScale(WIDTH, 0, Math.max(4, why.total) + 0.5);
  const up = evidenceScale(
    HEIGHT,
    limits,
    curve.map(([, value]) => value),
  );
  const x = (n: number): number => toPixel(n, across);
  const y = (value: number): number => toPixel(value, up);
  const paths = { level: "", hit: "", miss: "" };
  for (const [i, [n, value]] of curve.entries()) {
    const [next, after] = curve[i + 1] ?? [why.total + 0.5, value];
    paths.level += `M${x(n)} ${y(value)}H${x(next)}`;
    if (after !== value) paths[after > value ? "hit" : "miss"] += `M${x(next)} ${y(value)}V${y(after)}`;
  }
  const isRoomy = x(1) - x(0) >= ROOMY_PX;
  const at = selected.value;
  const point = (event: PointerEvent & { readonly currentTarget: SVGSVGElement }): void => {
    const box = event.currentTarget.getBoundingClientRect();
    const n = Math.round(toValue(((event.clientX - box.left) / box.width) * WIDTH, across));
    if (why.total > 0) onSelect(Math.min(why.total, Math.max(1, n)));
  };
  return (
    <svg
      class="cell-chart why-chart"
      viewBox={`0 0 ${WIDTH} ${HEIGHT + TITLE_PX}`}
      role="presentation"
      onPointerDown={point}
      onPointerMove={point}
    >
      <LogOddsBackground width={WIDTH} evidence={up} limits={limits} />
      <ReadingTitle width={WIDTH} height={HEIGHT} text="beams through this cell" />
      {at && <line class="why-now" x1={x(at.n)} x2={x(at.n)} y1={up.from} y2={up.to} />}
      <path class="why-level" d={paths.level} />
      <path class="why-miss" d={paths.miss} />
      <path class="why-hit" d={paths.hit} />
      <ZoneNames width={WIDTH} evidence={up} />
      {!isRoomy && (
        <>
          <path class="why-hit" d={rug(why, true, x, up.to)} />
          <path class="why-miss" d={rug(why, false, x, up.from - 5)} />
        </>
      )}
      {isRoomy &&
        why.contributions.map(({ n, hit, log_odds }) => (
          <circle key={n} class={hit ? "dot-hit" : "dot-miss"} cx={x(n)} cy={y(log_odds)} r={2.5} />
        ))}
      {at && <circle class={`why-dot ${at.hit ? "dot-hit" : "dot-miss"}`} cx={x(at.n)} cy={y(at.log_odds)} r={5} />}
    </svg>
  );
}

/** A tick for each hit, or each miss, along an edge: at the clamp the line alone does not show them. */
function rug(why: WhyMessage, hits: boolean, x: (n: number) => number, top: number): string {
  let path = "";
  for (const { n, hit } of why.contributions) if (hit === hits) path += `M${x(n)} ${top}v5`;
  return path;
}
