import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { PlayButton } from "../common/PlayButton";
import { Walls } from "../common/Scene";
import { useSeen, useSteps } from "../common/useSteps";
import { paintCloud } from "../localization/paint";
import { DRIVE } from "../stage/floor";
import { type MarkProps, type Scene, scene } from "../stage/scene";
import { paintCosts, paintPath } from "./paint";
import { Goal } from "./scenes";
import {
  begin,
  CRATE,
  driveAt,
  FIRST_STEP,
  goal,
  LENGTH,
  type Phase,
  phaseOf,
  restart,
  scansAt,
  setGoal,
  step,
  walkAt,
} from "./stack";
import "./navigation.css";

function StackMarks({ transform }: MarkProps) {
  const [phase, index] = phaseOf(step.value);
  const to = goal.value;
  const pose =
    phase === "slam"
      ? DRIVE[scansAt(index) - 1]
      : phase === "save"
        ? DRIVE.at(-1)
        : phase === "amcl"
          ? walkAt(index).robot
          : driveAt(index).walk.robot;
  return (
    <>
      {phase === "nav2" && <Walls transform={transform} walls={CRATE} tone="wall" />}
      {pose && (
        <g transform={`translate(${transform.x(pose[0])} ${transform.y(pose[1])})`}>
          <RobotShape yaw={pose[2]} size={Math.max(8, Math.min(22, 0.2 * transform.metre))} />
        </g>
      )}
      {phase === "nav2" && (
        <DragHandle
          transform={transform}
          at={to}
          label="Goal"
          sentence="Moves the goal; the path follows, and the robot drives there."
          text={`${written(to[0], 2)} m, ${written(to[1], 2)} m`}
          step={0.2}
          onMove={setGoal}
        >
          <Goal refused={!driveAt(index).plan.path} />
        </DragHandle>
      )}
    </>
  );
}

function caption(): string {
  const [phase, index] = phaseOf(step.value);
  if (phase === "slam")
    return `SLAM: the robot drives through the building once; poses and map are made together. ${scansAt(index)} of ${DRIVE.length} scans.`;
  if (phase === "save")
    return "Saved: each cell is occupied, free or unknown in map.pgm, and map.yaml says how to read it.";
  if (phase === "amcl") {
    const near = written(100 * (walkAt(index).past.at(-1)?.near ?? 0), 0);
    return `AMCL: another day, the robot is somewhere on the saved map. After ${index} scans ${near} % of the belief is at the robot.`;
  }
  const { plan, arrived } = driveAt(index);
  if (arrived) return "Nav2: the robot is at its goal.";
  if (!plan.path) return "Nav2: no path leads to the goal.";
  return `Nav2: a path of ${written(plan.length, 1)} m on the costmap. The crate is not in the saved map: the obstacle layer has what the scans saw of it.`;
}

/** The stage of the whole stack. */
export function stackScene(): Scene {
  const [phase, index] = phaseOf(step.value);
  void goal.value;
  return scene({
    scans: phase === "slam" ? scansAt(index) : DRIVE.length,
    trinary: phase !== "slam",
    overlay: (context, at) => {
      const now = phase === "nav2" ? driveAt(index) : null;
      const walk = now?.walk ?? (phase === "amcl" ? walkAt(index) : null);
      if (now) paintCosts(context, at, now.costs);
      if (walk) paintCloud(context, at, walk.particles, walk);
      if (now?.plan.path) paintPath(context, at, now.plan.path);
    },
    drawing: StackMarks,
    caption,
    task: phase === "nav2" ? "Drag the goal." : "",
  });
}

const PARTS: readonly { readonly phase: Phase; readonly name: string; readonly text: string }[] = [
  { phase: "slam", name: "SLAM Toolbox", text: "drives once through the building: poses and map together" },
  { phase: "save", name: "map.pgm + map.yaml", text: "the saved map" },
  { phase: "amcl", name: "AMCL", text: "a particle filter that finds the robot on the map" },
  {
    phase: "nav2",
    name: "Nav2",
    text: "the saved map as static layer, the current scan on top, inflation, a path, and the drive",
  },
];
const MS = 180;

/** The parts of the stack in their order; each can be begun with, and all of it plays. */
export function Stack() {
  const root = useRef<HTMLDivElement>(null);
  const playing = useSignal(false);
  useSteps(
    playing,
    useSeen(root),
    () => MS,
    () => {
      step.value = Math.min(LENGTH - 1, step.peek() + 1);
      if (step.peek() === LENGTH - 1) playing.value = false;
    },
  );
  const [phase] = phaseOf(step.value);
  const go = (to: number): void => {
    playing.value = false;
    step.value = to;
  };
  return (
    <div class="stack-controls stack-narrow" ref={root}>
      <ol class="production">
        {PARTS.map((part) => (
          <li key={part.phase} aria-current={part.phase === phase ? "step" : undefined}>
            <button type="button" class="stack-part printed" onClick={() => go(begin(part.phase))}>
              {part.name}
            </button>
            <span>{part.text}</span>
          </li>
        ))}
      </ol>
      <div class="figure-controls no-print">
        <PlayButton
          playing={playing}
          isPrimary
          onPress={() => {
            if (!playing.peek() && step.peek() === LENGTH - 1) restart();
          }}
        />
        <Button
          icon="restart"
          onClick={() => {
            playing.value = false;
            restart();
          }}
        >
          From the start
        </Button>
        <Slider
          label="Step"
          sentence="Steps from the first scan of the map to the goal."
          value={step.value}
          initial={FIRST_STEP}
          low={0}
          high={LENGTH - 1}
          step={1}
          onInput={go}
        />
      </div>
    </div>
  );
}
