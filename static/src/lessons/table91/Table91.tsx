import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { signed } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { PlayButton } from "../common/PlayButton";
import { useSeen, useSteps } from "../common/useSteps";
import { visited } from "../stage/controls";
import { LOOP_CELLS, LOOP_GEOMETRY, visitOf } from "../stage/loop";
import "./table91.css";

const L = ({ at }: { at: string }) => (
  <i>
    ℓ<sub>{at}</sub>
  </i>
);

/** The table's lines, with the indentation of its loop and condition. */
const LINES: readonly { readonly depth: number; readonly text: ComponentChildren }[] = [
  {
    depth: 0,
    text: (
      <>
        <b>Algorithm</b> occupancy_grid_mapping(&#123;
        <L at="t−1,i" />
        &#125;, x<sub>t</sub>, z<sub>t</sub>):
      </>
    ),
  },
  {
    depth: 1,
    text: (
      <>
        for all cells m<sub>i</sub> do
      </>
    ),
  },
  {
    depth: 2,
    text: (
      <>
        if m<sub>i</sub> in perceptual field of z<sub>t</sub> then
      </>
    ),
  },
  {
    depth: 3,
    text: (
      <>
        <L at="t,i" /> = <L at="t−1,i" /> + inverse_sensor_model(m<sub>i</sub>, x<sub>t</sub>, z<sub>t</sub>) −{" "}
        <L at="0" />
      </>
    ),
  },
  { depth: 2, text: <>else</> },
  {
    depth: 3,
    text: (
      <>
        <L at="t,i" /> = <L at="t−1,i" />
      </>
    ),
  },
  { depth: 2, text: <>endif</> },
  { depth: 1, text: <>endfor</> },
  {
    depth: 1,
    text: (
      <>
        return &#123;
        <L at="t,i" />
        &#125;
      </>
    ),
  },
];

/** Numbers of the lines that run for a cell in the field and for one outside it. */
const IN_FIELD = [3, 4];
const OUTSIDE = [3, 5, 6];
const MS = 60;

/** Table 9.1 with the lines highlighted that run for the present cell; the stage shows the cell and the map. */
export function Table91() {
  const playing = useSignal(false);
  const root = useRef<HTMLDivElement>(null);
  const done = visited.value;
  const go = (next: number): void => {
    visited.value = Math.min(LOOP_CELLS, Math.max(1, next));
    if (next >= LOOP_CELLS) playing.value = false;
  };
  useSteps(
    playing,
    useSeen(root),
    () => MS,
    () => go(visited.peek() + 1),
  );
  const { cell, inField, evidence, before, after } = visitOf(done - 1);
  const lit = inField ? IN_FIELD : OUTSIDE;
  return (
    <div class="table91 stack-narrow" ref={root}>
      <ol aria-label="Lines of table 9.1">
        {LINES.map(({ depth, text }, i) => (
          <li
            key={`line ${i + 1}`}
            class={lit.includes(i + 1) ? "lit" : ""}
            style={{ "--depth": depth }}
            {...(lit.includes(i + 1) ? { "aria-current": "step" as const } : {})}
          >
            {text}
          </li>
        ))}
      </ol>
      <p class="number" aria-live={playing.value ? "off" : "polite"}>
        Cell {done} of {LOOP_CELLS} (row {cell.row}, column {cell.col}):{" "}
        {inField ? (
          <>
            in the perceptual field, {signed(before)} {evidence < 0 ? "−" : "+"} {Math.abs(evidence).toFixed(2)} − 0 ={" "}
            <b>{signed(after)}</b>
            {Math.abs(before + evidence - after) > 1e-6 && " after the clamp"}.
          </>
        ) : (
          <>
            not in the perceptual field, <b>{signed(after)}</b> stays.
          </>
        )}
      </p>
      <Slider
        label="Cells visited"
        sentence="How many of the cells the loop has visited, row by row from below."
        value={done}
        initial={233}
        low={1}
        high={LOOP_CELLS}
        step={1}
        onInput={(value) => go(value)}
      />
      <div class="actions no-print">
        <Button icon="stepBack" label="Back one cell of the loop" onClick={() => go(done - 1)} />
        <PlayButton
          playing={playing}
          play="Run the loop"
          pause="Pause the loop"
          onPress={() => {
            if (done >= LOOP_CELLS) visited.value = 1;
          }}
        />
        <Button icon="stepForward" label="Forward one cell of the loop" onClick={() => go(done + 1)} />
        <Button onClick={() => go(done - (done % LOOP_GEOMETRY.cols) + LOOP_GEOMETRY.cols)}>Next row</Button>
      </div>
    </div>
  );
}
