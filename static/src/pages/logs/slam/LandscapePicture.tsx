/** The score of the poses around the selected loop, as a picture; the pose under the pointer moves the scan on the map. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { tokenRgb } from "../../../style/colour";
import { type LandscapePlace, placeAt, presentIn, summitOf } from "../../../tools/slam/scoreLandscape";
import { isDark } from "../../../ui/browser/theme";
import { signed } from "../../../ui/numbers";
import type { ScoreLandscape } from "../../../wire/http";
import type { PoseCorrection } from "./poseCorrection";

const KEYS: Record<string, readonly [col: number, row: number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/** Percent into a colour: the higher, the stronger. */
function paint(canvas: HTMLCanvasElement, { size, scores }: ScoreLandscape): void {
  const context = canvas.getContext("2d");
  if (!context) return;
  const [low, high] = [tokenRgb("--surface"), tokenRgb("--beam")];
  const greatest = Math.max(1, ...scores);
  const image = context.createImageData(size, size);
  scores.forEach((score, index) => {
    const share = (score / greatest) ** 2;
    const [row, col] = [Math.floor(index / size), index % size];
    const rgb = low.map((from, k) => from + share * ((high[k] ?? 0) - from));
    image.data.set([...rgb, 255], 4 * ((size - 1 - row) * size + col));
  });
  context.putImageData(image, 0, 0);
}

const sentence = ({ score, dx, dy, turnDeg }: LandscapePlace): string =>
  `${score} % at ${signed(dx, 2)} m, ${signed(dy, 2)} m, ${signed(turnDeg, 0)}°`;

export function LandscapePicture({
  correction,
  landscape,
}: {
  readonly correction: PoseCorrection;
  readonly landscape: ScoreLandscape;
}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const probe = useSignal<LandscapePlace | null>(null);
  useSignalEffect(() => {
    void isDark.value;
    const now = correction.landscape.value;
    if (canvas.current && now) paint(canvas.current, now);
  });
  const show = (place: LandscapePlace | null): void => {
    probe.value = place;
    correction.tryPlace(place);
  };
  const at = (event: PointerEvent): LandscapePlace => {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    const col = ((event.clientX - box.left) / box.width) * landscape.size - 0.5;
    return placeAt(landscape, col, landscape.size - 0.5 - ((event.clientY - box.top) / box.height) * landscape.size);
  };
  const middle = landscape.size / 2;
  const [col, row] = presentIn(landscape);
  const mark = probe.value;
  const best = summitOf(landscape);
  const reach = (((landscape.size - 1) / 2) * landscape.cell_m).toFixed(0);
  return (
    <figure class="landscape">
      <div
        class="landscape-picture"
        role="slider"
        tabIndex={0}
        aria-label="Scores of the poses around the loop"
        aria-valuenow={(mark ?? best).score}
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuetext={sentence(mark ?? best)}
        onPointerMove={(event) => show(at(event))}
        onPointerDown={(event) => show(at(event))}
        onPointerLeave={() => show(null)}
        onBlur={() => show(null)}
        onKeyDown={(event) => {
          const step = KEYS[event.key];
          if (!step) return;
          event.preventDefault();
          const from = probe.peek() ?? placeAt(landscape, middle - 0.5, middle - 0.5);
          show(placeAt(landscape, from.col + step[0], from.row + step[1]));
        }}
      >
        <canvas ref={canvas} width={landscape.size} height={landscape.size} />
        <svg viewBox={`0 0 ${landscape.size} ${landscape.size}`} aria-hidden="true">
          <path class="landscape-measured" d={`M${middle - 2} ${middle}h4M${middle} ${middle - 2}v4`} />
          <circle class="landscape-present" cx={col + 0.5} cy={landscape.size - row - 0.5} r={1.4} />
          {mark && <rect class="landscape-probe" x={mark.col} y={landscape.size - 1 - mark.row} width={1} height={1} />}
        </svg>
      </div>
      <figcaption class="quiet">
        <span class="landscape-text">{mark ? sentence(mark) : `Best: ${sentence(best)}`}</span>
        <span>
          Score of the later scan within {reach} m of where the loop puts it (+), at the best angle; the ring is its
          pose. Point at a place to see the scan there on the map.
        </span>
        <Turns landscape={landscape} />
      </figcaption>
    </figure>
  );
}

/** The greatest score at each angle. */
function Turns({ landscape }: { readonly landscape: ScoreLandscape }) {
  const n = landscape.by_turn.length;
  const path = landscape.by_turn
    .map((score, k) => `${k ? "L" : "M"}${(100 * k) / (n - 1)} ${30 - 0.28 * score}`)
    .join("");
  const end = ((n - 1) / 2) * landscape.turn_deg;
  return (
    <span class="landscape-turns">
      <svg viewBox="0 0 100 30" preserveAspectRatio="none" role="img" aria-label="Greatest score at each angle">
        <path d="M50 0V30" />
        <path class="landscape-curve" d={path} />
      </svg>
      <span>−{end}°</span>
      <span>angle</span>
      <span>+{end}°</span>
    </span>
  );
}
