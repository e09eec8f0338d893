import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import { indexOf } from "../../grid/occupancyGrid";
import { bayesFilter } from "../../grid/textbook";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { signed, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { PlayButton } from "../common/PlayButton";
import { useInSight, useSeen, useSteps } from "../common/useSteps";
import { pipelineBeam, pipelineStep } from "../stage/controls";
import { readingOf } from "../stage/reading";
import { nowOf, type Scene } from "../stage/scene";
import { ALGORITHM } from "../stage/scenes";
import "./pipeline.css";

/** More than 0.5 of log-odds decides. */
const DECIDED = 0.5;

export const stateCharacter = (logOdds: number): string => (logOdds > DECIDED ? "#" : logOdds < -DECIDED ? "." : "?");

/** The least probability of each character; below all of them, the most certainly free. */
const STEPS = [
  [0.9, "#"],
  [0.7, "o"],
  [0.55, "+"],
  [0.45, " "],
  [0.3, "−"],
  [0.1, "."],
] as const;

/** The character of the first step that p reaches; a dot, as for 0.1, below them all. */
export const densityCharacter = (logOdds: number): string => {
  const p = probability(logOdds);
  return STEPS.find(([least]) => p >= least)?.[1] ?? ".";
};

const MS = 1400;
const LAST = 6;
const DEGREE = Math.PI / 180;

interface Box {
  readonly name: string;
  readonly formula: ComponentChildren;
  readonly value: ComponentChildren;
}

/** What each step of the pipeline makes of the selected reading. */
function boxes(scene: Scene): readonly Box[] {
  const shown = nowOf(scene);
  const reading = readingOf(scene, shown, pipelineBeam.value);
  if (!reading) return [];
  const { cells } = reading;
  const before = nowOf({ ...scene, poses: scene.poses.slice(0, -1) }).map;
  const index = indexOf(shown.map.geometry, reading.cell);
  const l = before.logOdds[index] ?? 0;
  const after = bayesFilter(l, scene.config.log_odds_hit, scene.config);
  const free = cells.filter(({ evidence }) => evidence < 0).length;
  return [
    {
      name: "reading",
      formula: "z, α",
      value: `${written(reading.range, 2)} m, ${written(reading.bearing / DEGREE, 0)}°`,
    },
    {
      name: "end point",
      formula: "x + z cos(θ + α), y + z sin(θ + α)",
      value: `${written(reading.end[0], 2)} m, ${written(reading.end[1], 2)} m`,
    },
    {
      name: "cell",
      formula: "floor((p − origin) / resolution)",
      value: `column ${reading.cell.col}, row ${reading.cell.row}`,
    },
    { name: "cells of the beam", formula: "Bresenham’s line", value: `${cells.length} cells` },
    {
      name: "evidence",
      formula: "inverse sensor model",
      value: (
        <>
          <span class="noun-miss">
            {free} × {signed(scene.config.log_odds_miss)}
          </span>
          , <span class="noun-hit">1 × {signed(scene.config.log_odds_hit)}</span>
        </>
      ),
    },
    {
      name: "log-odds of the last cell",
      formula: "ℓ + evidence − ℓ₀, clamped",
      value: `${signed(l)} → ${signed(after)}`,
    },
    {
      name: "shown",
      formula: "p = 1 − 1/(1 + exp ℓ)",
      value: (
        <>
          {written(probability(after), 2)}, character <kbd>{densityCharacter(after)}</kbd> or{" "}
          <kbd>{stateCharacter(after)}</kbd>
        </>
      ),
    },
  ];
}

/** The whole way of one reading, in the two loops that are around it. */
export function Pipeline() {
  const playing = useSignal(false);
  const root = useRef<HTMLDivElement>(null);
  const inView = boxes(useInSight(root, ALGORITHM.reading));
  const at = pipelineStep.value;
  const go = (next: number): void => {
    pipelineStep.value = Math.min(LAST, Math.max(0, next));
    if (next >= LAST) playing.value = false;
  };
  useSteps(
    playing,
    useSeen(root),
    () => MS,
    () => go(pipelineStep.peek() + 1),
  );
  return (
    <div class="pipeline stack" ref={root}>
      <div class="pipeline-loop">
        <p class="pipeline-loop-name">for each scan, with its pose x, y, θ</p>
        <div class="pipeline-loop">
          <p class="pipeline-loop-name">for each beam of the scan</p>
          {inView.length === 0 ? (
            <p>This beam has no return and is ignored.</p>
          ) : (
            <ol class="pipeline-steps">
              {inView.map(({ name, formula, value }, i) => (
                <li
                  key={name}
                  class={i < at ? "done" : i === at ? "now" : ""}
                  {...(i === at ? { "aria-current": "step" as const } : {})}
                >
                  <b>{name}</b>
                  <span class="pipeline-formula">{formula}</span>
                  <output class="number">{value}</output>
                </li>
              ))}
            </ol>
          )}
        </div>
      </div>
      <div class="actions no-print">
        <Button icon="stepBack" label="Back one step of the pipeline" disabled={at === 0} onClick={() => go(at - 1)} />
        <PlayButton
          playing={playing}
          play="Let the reading travel"
          pause="Pause the reading"
          onPress={() => {
            if (at >= LAST) pipelineStep.value = 0;
          }}
        />
        <Button
          icon="stepForward"
          label="Forward one step of the pipeline"
          disabled={at === LAST}
          onClick={() => go(at + 1)}
        />
      </div>
      <Slider
        label="Beam of the scan"
        sentence="Selects the beam whose reading is followed, counter-clockwise from straight ahead."
        {...bound(pipelineBeam)}
        initial={36}
        low={0}
        high={239}
        step={1}
        tone="beam"
      />
    </div>
  );
}
