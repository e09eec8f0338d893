import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { reducedMotion } from "../../ui/browser/media";
import { Slider } from "../../ui/Slider";
import { useSeen, useSteps } from "../common/useSteps";
import { begin, FIRST_STEP, LENGTH, type Phase, phaseOf, restart, step } from "./stack";
import "./navigation.css";

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
        {!reducedMotion.value && (
          <Button
            kind="primary"
            icon={playing.value ? "pause" : "play"}
            onClick={() => {
              if (!playing.peek() && step.peek() === LENGTH - 1) restart();
              playing.value = !playing.peek();
            }}
          >
            {playing.value ? "Pause" : "Play"}
          </Button>
        )}
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
