/** The pose graph: its loops, the selected one with both scans, and why no loop closed at a place. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import type { Store } from "../../../store/store";
import { tokenRgb } from "../../../style/colour";
import { residualLabel, whyNone } from "../../../tools/slam/poseGraph";
import { type LandscapePlace, placeAt, presentIn, summitOf } from "../../../tools/slam/scoreLandscape";
import { Button } from "../../../ui/Button";
import { isDark } from "../../../ui/browser/theme";
import { Choice } from "../../../ui/Choice";
import { plural, signed, written } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import { Slider } from "../../../ui/Slider";
import type { PoseGraphAnswer, ScoreLandscape } from "../../../wire/http";
import type { PoseCorrection } from "./poseCorrection";

const KEYS: Record<string, readonly [col: number, row: number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/** A percentage as a colour: the higher, the stronger. */
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

function LandscapePicture({
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

interface GraphProps {
  readonly store: Store;
  readonly correction: PoseCorrection;
  readonly graph: PoseGraphAnswer;
  readonly isGuest: boolean;
}

const MOST_LOOPS = 60;
const KERNELS: readonly { value: string; label: string }[] = [
  { value: "geman_mcclure", label: "Geman–McClure" },
  { value: "cauchy", label: "Cauchy" },
  { value: "huber", label: "Huber" },
  { value: "none", label: "None" },
];
const FIRST_SCALE = 3;

export function Graph({ store, correction, graph, isGuest }: GraphProps) {
  const { loops } = graph;
  return (
    <Panel title="Pose graph" note={`${graph.nodes} poses, ${loops.length} of ${graph.tried} loops tried`}>
      <div class="panel-stack">
        <p class="quiet">
          Click a loop in the map to inspect it, any other place to ask why no loop closed there. Solid lines fit,
          dashed ones are strained, dotted ones contradict the rest.
        </p>
        <Pointed correction={correction} />
        <Selected correction={correction} isGuest={isGuest} />
        <SelectedPose correction={correction} />
        <Why store={store} correction={correction} isGuest={isGuest} />
        {!isGuest && <Solving correction={correction} graph={graph} />}
        <details>
          <summary>Loops, the worst first</summary>
          <ul class="loop-list" aria-label="Loops">
            {loops.slice(0, MOST_LOOPS).map((loop) => (
              <li key={loop.edge}>
                <Button
                  kind="quiet"
                  pressed={correction.edge.value?.edge === loop.edge}
                  onClick={() => void correction.select(loop.edge)}
                >
                  <span>
                    scans {loop.scans[0] + 1} and {loop.scans[1] + 1}
                    {loop.locked && ", locked"}
                  </span>
                  <span>
                    {loop.residual.toFixed(1)} σ, {residualLabel(loop.residual)}
                  </span>
                </Button>
              </li>
            ))}
          </ul>
          {loops.length > MOST_LOOPS && <p class="quiet">And {loops.length - MOST_LOOPS} more that fit better.</p>}
        </details>
      </div>
    </Panel>
  );
}

/** The edge under the pointer. */
function Pointed({ correction }: { readonly correction: PoseCorrection }) {
  const edge = correction.hovered.value;
  return (
    <p class="edge-pointed quiet">
      {edge
        ? `Under the pointer: ${edge.kind === "loop" ? "loop" : "odometry"} between scans ${edge.scans[0] + 1} and ${edge.scans[1] + 1}, ${edge.residual.toFixed(1)} σ.`
        : "Point at an edge to see both of its scans aligned."}
    </p>
  );
}

/** The edges that determine the selected pose, with the residual of each. */
function SelectedPose({ correction }: { readonly correction: PoseCorrection }) {
  const now = correction.constraints.value;
  if (!now) return null;
  return (
    <section class="loop-detail" aria-label="Selected pose">
      <p>
        <strong>Pose of scan {now.scan + 1}</strong>: {plural(now.edges.length, "edge")} of the graph determine
        {now.edges.length === 1 && "s"} it, the greatest residual first.
      </p>
      <ul class="loop-list">
        {now.edges.map(({ edge, kind, scans, residual, weight, off_m, off_deg }) => (
          <li key={edge}>
            <Button kind="quiet" onClick={() => void correction.select(edge)}>
              <span>
                {kind === "loop" ? "loop with" : "odometry to"} scan {(scans[0] === now.scan ? scans[1] : scans[0]) + 1}
              </span>
              <span>
                {written(residual, 1)} σ: {written(off_m, 3)} m, {written(off_deg, 2)}°
                {kind === "loop" && `, weight ${Math.round(100 * weight)} %`}
              </span>
            </Button>
          </li>
        ))}
      </ul>
    </section>
  );
}

/** The selected edge. */
function Selected({ correction, isGuest }: { readonly correction: PoseCorrection; readonly isGuest: boolean }) {
  const edge = correction.edge.value;
  if (!edge) return null;
  const { kind, scans, residual, weight, off_m, off_deg, score, inliers, locked } = edge;
  return (
    <section class="loop-detail" aria-label={kind === "loop" ? "Selected loop" : "Selected edge"}>
      <p>
        <strong>
          {kind === "loop" ? "Loop" : "Odometry"} between scans {scans[0] + 1} and {scans[1] + 1}
        </strong>
        : {residualLabel(residual)}.
      </p>
      <dl class="facts-list">
        <dt>Residual</dt>
        <dd>
          {residual.toFixed(2)} σ: {off_m.toFixed(3)} m and {off_deg.toFixed(2)}° off
        </dd>
        <dt>Weight left</dt>
        <dd>{Math.round(100 * weight)} %</dd>
        {score !== null && (
          <>
            <dt>Correlation</dt>
            <dd>{Math.round(100 * score)} %</dd>
          </>
        )}
        {inliers !== null && (
          <>
            <dt>Points on walls</dt>
            <dd>{Math.round(100 * inliers)} %</dd>
          </>
        )}
      </dl>
      {correction.landscape.value && (
        <LandscapePicture correction={correction} landscape={correction.landscape.value} />
      )}
      <p class="quiet">
        Dots are the earlier scan, faint crosses the later one at its pose, full crosses where this edge puts it.
      </p>
      {!isGuest && kind === "loop" && (
        <div class="actions">
          <Button
            icon="trash"
            disabled={correction.isBusy.value}
            onClick={() => void correction.change({ remove: edge.edge })}
          >
            Remove this loop
          </Button>
          <Button
            pressed={locked}
            disabled={correction.isBusy.value}
            onClick={() => void correction.change(locked ? { unlock: edge.edge } : { lock: edge.edge })}
          >
            {locked ? "Locked" : "Lock"}
          </Button>
        </div>
      )}
    </section>
  );
}

/** Why no loop closed at a place: the attempts there, and the test that rejected each. */
function Why({ store, correction, isGuest }: Omit<GraphProps, "graph">) {
  const place = correction.place.value;
  const refused = correction.candidate.value?.accepted === false ? correction.candidate.value : null;
  const pair = refused?.scans ?? place?.found.pair ?? null;
  const pose = store.frame.value?.pose;
  return (
    <>
      <div class="actions">
        {pose && (
          <Button kind="quiet" onClick={() => void correction.ask([pose[0], pose[1]])}>
            Why no loop at the robot?
          </Button>
        )}
      </div>
      {place && (
        <section class="loop-detail" aria-label="Why no loop closed here">
          <p>
            <strong>
              Near ({place.at[0].toFixed(1)}, {place.at[1].toFixed(1)})
            </strong>
            : {whyNone(place.found)}
          </p>
          <ul class="loop-list" aria-label="Loops that were tried">
            {place.found.candidates.map((candidate) => (
              <li key={candidate.candidate}>
                <Button
                  kind="quiet"
                  pressed={correction.candidate.value?.candidate === candidate.candidate}
                  onClick={() => void correction.selectCandidate(candidate.candidate)}
                >
                  <span>
                    scans {candidate.scans[0] + 1} and {candidate.scans[1] + 1}
                  </span>
                  <span>
                    {candidate.accepted ? "accepted" : `refused: ${candidate.reason}`} (score{" "}
                    {candidate.score.toFixed(2)})
                  </span>
                </Button>
              </li>
            ))}
          </ul>
          {pair && !isGuest && (
            <div class="actions">
              <Button disabled={correction.isBusy.value} onClick={() => void correction.change({ add: pair })}>
                Close a loop between scans {pair[0] + 1} and {pair[1] + 1}
              </Button>
            </div>
          )}
        </section>
      )}
    </>
  );
}

/** The robust kernel; the graph is solved again while its scale is dragged. */
function Solving({ correction, graph }: { readonly correction: PoseCorrection; readonly graph: PoseGraphAnswer }) {
  return (
    <>
      <Choice
        label="Robust kernel"
        options={KERNELS}
        value={graph.robust}
        sentence="How loops that contradict the rest of the graph lose weight."
        onChange={(robust) => void correction.change({ robust })}
      />
      <Slider
        label="Kernel scale"
        value={graph.robust_scale}
        initial={FIRST_SCALE}
        low={0.5}
        high={50}
        step={0.5}
        unit="σ"
        sentence="Loops with larger residuals lose weight."
        disabled={graph.robust === "none"}
        onInput={(robust_scale) => void correction.change({ robust_scale })}
      />
      {graph.changed && (
        <div class="actions">
          <Button disabled={correction.isBusy.value} onClick={() => void correction.keep()}>
            Keep this graph
          </Button>
          <Button
            kind="quiet"
            icon="undo"
            disabled={correction.isBusy.value}
            onClick={() => void correction.change({ reset: true })}
          >
            As SLAM left it
          </Button>
        </div>
      )}
    </>
  );
}
