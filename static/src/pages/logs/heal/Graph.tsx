/** The pose graph: its loops, the selected one with both scans, and why no loop closed at a place. */

import type { Store } from "../../../store/store";
import { residualLabel, whyNone } from "../../../tools/heal/model";
import { Button } from "../../../ui/Button";
import { Choice } from "../../../ui/Choice";
import { Panel } from "../../../ui/Panel";
import { Slider } from "../../../ui/Slider";
import type { PoseGraphAnswer } from "../../../wire/http";
import type { Healing } from "./healing";
import { ScoreHill } from "./ScoreHill";

interface GraphProps {
  readonly store: Store;
  readonly healing: Healing;
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

export function Graph({ store, healing, graph, isGuest }: GraphProps) {
  const { loops } = graph;
  return (
    <Panel title="Pose graph" note={`${graph.nodes} poses, ${loops.length} of ${graph.tried} loops tried`}>
      <div class="heal">
        <p class="quiet">
          Click a loop in the map to inspect it, any other place to ask why no loop closed there. Solid lines fit,
          dashed ones are strained, dotted ones contradict the rest.
        </p>
        <Pointed healing={healing} />
        <Selected healing={healing} isGuest={isGuest} />
        <Why store={store} healing={healing} isGuest={isGuest} />
        {!isGuest && <Solving healing={healing} graph={graph} />}
        <details>
          <summary>Loops, the worst first</summary>
          <ul class="heal-loops" aria-label="Loops">
            {loops.slice(0, MOST_LOOPS).map((loop) => (
              <li key={loop.edge}>
                <Button
                  kind="quiet"
                  pressed={healing.edge.value?.edge === loop.edge}
                  onClick={() => void healing.select(loop.edge)}
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
function Pointed({ healing }: { readonly healing: Healing }) {
  const edge = healing.hovered.value;
  return (
    <p class="heal-pointed quiet">
      {edge
        ? `Under the pointer: ${edge.kind === "loop" ? "loop" : "odometry"} between scans ${edge.scans[0] + 1} and ${edge.scans[1] + 1}, ${edge.residual.toFixed(1)} σ.`
        : "Point at an edge to see both of its scans aligned."}
    </p>
  );
}

/** The selected loop, or the selected candidate. */
function Selected({ healing, isGuest }: { readonly healing: Healing; readonly isGuest: boolean }) {
  const edge = healing.edge.value;
  if (edge?.kind !== "loop") return null;
  const { scans, residual, weight, off_m, off_deg, score, inliers, locked } = edge;
  return (
    <section class="heal-selected" aria-label="Selected loop">
      <p>
        <strong>
          Loop between scans {scans[0] + 1} and {scans[1] + 1}
        </strong>
        : {residualLabel(residual)}.
      </p>
      <dl class="heal-facts">
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
      {healing.hill.value && <ScoreHill healing={healing} hill={healing.hill.value} />}
      <p class="quiet">
        Dots are the earlier scan, faint crosses the later one at its pose, full crosses where this loop puts it.
      </p>
      {!isGuest && (
        <div class="heal-actions">
          <Button
            icon="trash"
            disabled={healing.isBusy.value}
            onClick={() => void healing.change({ remove: edge.edge })}
          >
            Remove this loop
          </Button>
          <Button
            pressed={locked}
            disabled={healing.isBusy.value}
            onClick={() => void healing.change(locked ? { unlock: edge.edge } : { lock: edge.edge })}
          >
            {locked ? "Locked" : "Lock"}
          </Button>
        </div>
      )}
    </section>
  );
}

/** Why no loop closed at a place: what was tried there, and what refused it. */
function Why({ store, healing, isGuest }: Omit<GraphProps, "graph">) {
  const place = healing.place.value;
  const refused = healing.candidate.value?.accepted === false ? healing.candidate.value : null;
  const pair = refused?.scans ?? place?.found.pair ?? null;
  const pose = store.frame.value?.pose;
  return (
    <>
      <div class="heal-actions">
        {pose && (
          <Button kind="quiet" onClick={() => void healing.ask([pose[0], pose[1]])}>
            Why no loop at the robot?
          </Button>
        )}
      </div>
      {place && (
        <section class="heal-selected" aria-label="Why no loop closed here">
          <p>
            <strong>
              Near ({place.at[0].toFixed(1)}, {place.at[1].toFixed(1)})
            </strong>
            : {whyNone(place.found)}
          </p>
          <ul class="heal-loops" aria-label="Loops that were tried">
            {place.found.candidates.map((one) => (
              <li key={one.candidate}>
                <Button
                  kind="quiet"
                  pressed={healing.candidate.value?.candidate === one.candidate}
                  onClick={() => void healing.selectCandidate(one.candidate)}
                >
                  <span>
                    scans {one.scans[0] + 1} and {one.scans[1] + 1}
                  </span>
                  <span>
                    {one.accepted ? "accepted" : `refused: ${one.reason}`} (score {one.score.toFixed(2)})
                  </span>
                </Button>
              </li>
            ))}
          </ul>
          {pair && !isGuest && (
            <div class="heal-actions">
              <Button disabled={healing.isBusy.value} onClick={() => void healing.change({ add: pair })}>
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
function Solving({ healing, graph }: { readonly healing: Healing; readonly graph: PoseGraphAnswer }) {
  return (
    <>
      <Choice
        label="Robust kernel"
        options={KERNELS}
        value={graph.robust}
        sentence="How loops that contradict the rest of the graph lose weight."
        onChange={(robust) => void healing.change({ robust })}
      />
      <Slider
        label="Scale of the kernel"
        value={graph.robust_scale}
        initial={FIRST_SCALE}
        low={0.5}
        high={50}
        step={0.5}
        unit="σ"
        sentence="Loops with larger residuals lose weight."
        disabled={graph.robust === "none"}
        onInput={(robust_scale) => void healing.change({ robust_scale })}
      />
      {graph.changed && (
        <div class="heal-actions">
          <Button disabled={healing.isBusy.value} onClick={() => void healing.keep()}>
            Keep this graph
          </Button>
          <Button
            kind="quiet"
            icon="undo"
            disabled={healing.isBusy.value}
            onClick={() => void healing.change({ reset: true })}
          >
            As SLAM left it
          </Button>
        </div>
      )}
    </>
  );
}
