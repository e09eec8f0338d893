import { computed, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { GridGeometry, LaserScan } from "../../grid/occupancyGrid";
import { bearingOf } from "../../grid/textbook";
import { Button } from "../../ui/Button";
import { selected } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { signed, written } from "../../ui/numbers";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { PlayButton } from "../common/PlayButton";
import { Scene } from "../common/Scene";
import type { StageTransform } from "../common/Stage";
import { useSeen, useSteps } from "../common/useSteps";
import { box, type Lidar, scanFrom, type Wall } from "../common/world";
import { gridBefore, type Run, runProgram, type Step, type StepSize, stepFrom } from "./model";
import "./program.css";
import { PROGRAM, type SourceLine } from "./source";

const GEOMETRY: GridGeometry = { resolution: 0.25, rows: 11, cols: 14, origin: [0, 0, 0] };
const WALLS: readonly Wall[] = [...box(0.3, 0.3, 3.2, 2.45), [2.15, 2.45, 2.15, 1.6]];
const LIDAR: Lidar = {
  beams: 19,
  angle_min: -Math.PI / 2,
  angle_increment: Math.PI / 18,
  range_min: 0.05,
  range_max: 2.2,
};

const STEP_SIZES: readonly { readonly value: StepSize; readonly label: string }[] = [
  { value: "line", label: "line" },
  { value: "cell", label: "cell" },
  { value: "beam", label: "beam" },
  { value: "scan", label: "scan" },
];
const MS: Record<StepSize, number> = { line: 350, cell: 350, beam: 500, scan: 500 };

const inside = ([x, y]: Point): Point => [Math.min(3, Math.max(0.5, x)), Math.min(2.25, Math.max(0.5, y))];

/** The step that is shown at first: a beam whose evidence is partly in the map. */
const initialStep = (run: Run): number => {
  const index = run.steps.findIndex(
    (step) => step.fn === "bayes_filter" && (step.beam ?? 0) >= 12 && step.current === 4,
  );
  return Math.max(0, index);
};

/** The textbook's program with its current line highlighted, beside the small grid that it updates. */
export function Program() {
  const at = useSignal<Point>([0.88, 1.12]);
  const by = useSignal<StepSize>("line");
  const playing = useSignal(false);
  const root = useRef<HTMLElement>(null);
  const both = useMemo(
    () =>
      computed(() => {
        const pose: Pose = [at.value[0], at.value[1], 0];
        const scan = scanFrom(WALLS, pose, LIDAR);
        return { pose, scan, run: runProgram(GEOMETRY, scan, pose) };
      }),
    [at],
  );
  const step = useSignal(initialStep(both.value.run));
  const { pose, scan, run } = both.value;
  const now = Math.min(step.value, run.steps.length - 1);
  const grid = useMemo(() => computed(() => gridBefore(both.value.run, step.value)), [both, step]);
  const go = (direction: 1 | -1): void => {
    const current = both.peek().run;
    step.value = stepFrom(current, Math.min(step.peek(), current.steps.length - 1), by.peek(), direction);
    if (step.peek() >= current.steps.length - 1) playing.value = false;
  };
  useSteps(
    playing,
    useSeen(root),
    () => MS[by.value],
    () => go(1),
  );
  const here = run.steps[now];
  if (!here) return null;
  return (
    <figure class="program" ref={root} aria-label="The program, line by line, and the grid that it updates">
      <ProgramText here={here} />
      <div class="program-world">
        <Scene geometry={GEOMETRY} label="The grid that the program updates" grid={grid} walls={WALLS} lines>
          {(transform) => (
            <>
              <CurrentBeam transform={transform} here={here} pose={pose} scan={scan} />
              <DragHandle
                transform={transform}
                at={at.value}
                label="Robot"
                sentence="Moves the robot; the program then runs on the scan from there."
                text={`${written(at.value[0], 2)} m, ${written(at.value[1], 2)} m`}
                step={0.05}
                onMove={(point) => {
                  at.value = inside(point);
                }}
              >
                <RobotShape yaw={0} size={9} />
              </DragHandle>
            </>
          )}
        </Scene>
        <Values here={here} run={run} scan={scan} />
      </div>
      <div class="figure-controls no-print">
        <Choice label="Step size" bare options={STEP_SIZES} {...selected(by)} />
        <div class="actions">
          <Button icon="stepBack" label="Step back" onClick={() => go(-1)} />
          <PlayButton
            playing={playing}
            onPress={() => {
              if (now >= run.steps.length - 1) step.value = 0;
            }}
          />
          <Button icon="stepForward" label="Step forward" onClick={() => go(1)} />
          <Button
            icon="restart"
            label="Back to the start"
            onClick={() => {
              playing.value = false;
              step.value = 0;
            }}
          />
        </div>
        <output class="number" aria-live={playing.value ? "off" : "polite"}>
          line {now + 1} of {run.steps.length}, {here.done} updates
        </output>
      </div>
    </figure>
  );
}

const WORDS = /\b(def|for|in|if|elif|else|return|not|and|or)\b/g;

function coloured(text: string) {
  const parts = text.split(WORDS);
  return parts.map((part, i) => (i % 2 === 1 ? <b key={`${i}-${part}`}>{part}</b> : part));
}

/** The program's text; its box scrolls to the current line, the page does not scroll. */
function ProgramText({ here }: { here: Step }) {
  const box = useRef<HTMLElement>(null);
  const lit = useRef<HTMLElement>(null);
  useEffect(() => {
    const frame = box.current;
    if (!frame) return;
    const keepInSight = (): void => {
      const line = lit.current;
      if (!line) return;
      const [low, high] = [line.offsetTop - 40, line.offsetTop + line.offsetHeight + 40];
      if (low < frame.scrollTop) frame.scrollTop = low;
      else if (high > frame.scrollTop + frame.clientHeight) frame.scrollTop = high - frame.clientHeight;
    };
    keepInSight();
    // Also when the box changes its size or is first shown.
    const observer = new ResizeObserver(keepInSight);
    observer.observe(frame);
    return () => observer.disconnect();
  }, [here]);
  const isLit = (line: SourceLine): boolean => line.fn === here.fn && line.offset === here.offset;
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: a box that scrolls must be reachable by keyboard
    <section class="program-text" ref={box} tabIndex={0} aria-label="mapper/mapping/textbook.py, docstrings left out">
      {PROGRAM.map((lines) => (
        <pre key={lines[0]?.fn}>
          {lines.map((line) => (
            <code
              key={line.offset}
              class={isLit(line) ? "lit" : ""}
              style={{ "--indent": `${line.text.search(/\S|$/)}ch` }}
              {...(isLit(line) ? { ref: lit, "aria-current": "step" as const } : {})}
            >
              {coloured(line.text)}
              {"\n"}
            </code>
          ))}
        </pre>
      ))}
    </section>
  );
}

interface CurrentBeamProps {
  readonly transform: StageTransform;
  readonly here: Step;
  readonly pose: Pose;
  readonly scan: LaserScan;
}

/** The current beam, the cells that it gives evidence for, and the current cell. */
function CurrentBeam({ transform, here, pose, scan }: CurrentBeamProps) {
  const square = (cell: { row: number; col: number }) => ({
    x: cell.col * transform.cell + 1.5,
    y: transform.height - (cell.row + 1) * transform.cell + 1.5,
    width: transform.cell - 3,
    height: transform.cell - 3,
  });
  const bearing = pose[2] + bearingOf(scan, here.beam ?? 0);
  const range = scan.ranges[here.beam ?? 0] ?? 0;
  const z = Number.isFinite(range) ? range : scan.range_max;
  return (
    <>
      {here.evidence.map(({ cell, evidence }, i) => (
        <rect
          key={`${cell.row} ${cell.col}`}
          class={`program-cell ${evidence > 0 ? "hit" : "miss"}${i === here.current ? " now" : ""}`}
          {...square(cell)}
        />
      ))}
      {here.beam !== null && (
        <line
          class={`program-beam${Number.isFinite(range) ? "" : " none"}`}
          x1={transform.x(pose[0])}
          y1={transform.y(pose[1])}
          x2={transform.x(pose[0] + z * Math.cos(bearing))}
          y2={transform.y(pose[1] + z * Math.sin(bearing))}
        />
      )}
    </>
  );
}

/** The values of the program's variables at this line. */
function Values({ here, run, scan }: { here: Step; run: Run; scan: LaserScan }) {
  const cellEvidence = here.current === null ? undefined : here.evidence[here.current];
  const change = here.current === null ? undefined : run.changes[here.done];
  const made = here.current === null ? undefined : run.changes[here.done - 1];
  const isMade = here.fn === "update" && cellEvidence !== undefined && made?.cell === cellEvidence.cell;
  const shown = isMade ? made : change?.cell === cellEvidence?.cell ? change : undefined;
  const range = here.beam === null ? undefined : scan.ranges[here.beam];
  const degrees = here.beam === null ? "" : `${written((bearingOf(scan, here.beam) * 180) / Math.PI, 0)}°`;
  const rows: readonly (readonly [name: string, value: string, tone: string])[] = [
    ["beam", here.beam === null ? "" : `${here.beam + 1} of ${scan.ranges.length}`, ""],
    [
      "z, bearing",
      range === undefined ? "" : `${Number.isFinite(range) ? `${written(range, 2)} m` : "no return"}, ${degrees}`,
      "noun-beam",
    ],
    ["evidence", here.evidence.length === 0 ? "" : `${here.evidence.length} cells`, ""],
    ["cell", cellEvidence ? `row ${cellEvidence.cell.row}, column ${cellEvidence.cell.col}` : "", ""],
    [
      "increment",
      cellEvidence ? signed(cellEvidence.evidence) : "",
      cellEvidence && cellEvidence.evidence > 0 ? "noun-hit" : "noun-miss",
    ],
    [
      "log-odds",
      shown ? `${written(shown.before, 2)} ${isMade ? "→" : "will be"} ${written(shown.after, 2)}` : "",
      "noun-robot",
    ],
  ];
  return (
    <dl class="program-values" aria-live="off">
      {rows.map(([name, value, tone]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd class={tone}>{value || "·"}</dd>
        </div>
      ))}
    </dl>
  );
}
