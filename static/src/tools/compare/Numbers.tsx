/** Measures of the difference of two maps; a count of cells is a button that shows them in the picture. */

import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import type { Marked } from "../../render/map/difference";
import { written } from "../../ui/numbers";
import { Tooltip } from "../../ui/Tooltip";
import type { CellState, Numbers as Counted, Point } from "../../wire/protocol";
import type { Comparison } from "./comparison";

const STATES: readonly CellState[] = ["free", "occupied", "unknown"];

const HOW = {
  states:
    "Each cell of the smallest grid that contains both maps is counted once: occupied above p 0.65, free below 0.25, unknown in between and where nothing was observed.",
  entropy:
    "H(p) = −p log₂ p − (1 − p) log₂ (1 − p), summed over the cells that at least one map has observed; a cell that one map has not observed counts with its prior.",
  contrast:
    "The mean difference of p over all pairs of neighbouring observed cells of which one has p above 0.5 and the other does not; the maximum is 1.",
  only: "Cells that were observed in one map and never in the other.",
  mean: "The mean of |ℓ of B − ℓ of A| over the cells that both maps have observed.",
  most: "The greatest |ℓ of B − ℓ of A| of a cell that both maps have observed. Press to show it.",
};

interface NumbersProps {
  readonly comparison: Comparison;
  readonly numbers: Counted | null;
  /** Why there are no numbers. */
  readonly refused: string | null;
  readonly onGo: (place: Point) => void;
}

const count = (n: number | undefined): string => (n === undefined ? "…" : n.toLocaleString("en"));
const share = (value: number | undefined, places: number): string =>
  value === undefined ? "…" : written(value, places);

export function Numbers({ comparison, numbers, refused, onGo }: NumbersProps) {
  const marks = (marked: Marked, n: number | undefined, about: string, quiet = false) => (
    <Mark comparison={comparison} marked={marked} count={n} about={about} quiet={quiet} />
  );
  return (
    <div class="compare-numbers" data-cells={numbers?.cells}>
      <div class="compare-states">
        <table>
          <caption>
            Cells by state; press a number to show them
            <About text={HOW.states} about="the states" />
          </caption>
          <thead>
            <tr>
              <th scope="col">A ↓ &nbsp; B →</th>
              {STATES.map((state) => (
                <th key={state} scope="col">
                  {state}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {STATES.map((a, i) => (
              <tr key={a}>
                <th scope="row">{a}</th>
                {STATES.map((b, j) => (
                  <td key={b}>{marks({ a, b }, numbers?.states[i]?.[j], `${a} in A, ${b} in B`, a === b)}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
        <p class="quiet">{refused ?? `${count(numbers?.cells)} cells in all`}</p>
      </div>
      <table>
        <thead>
          <tr>
            <td class="number" />
            <th scope="col">A</th>
            <th scope="col">B</th>
          </tr>
        </thead>
        <tbody>
          <Row title="Known only in this map" how={HOW.only}>
            <td>{marks("only a", numbers?.only[0], "known only in A")}</td>
            <td>{marks("only b", numbers?.only[1], "known only in B")}</td>
          </Row>
          <Row title="Entropy, bits" how={HOW.entropy}>
            {[0, 1].map((side) => (
              <td key={side} class="number">
                {count(numbers ? Math.round(numbers.entropy_bits[side as 0 | 1]) : undefined)}
              </td>
            ))}
          </Row>
          <Row title="Sharpness of walls" how={HOW.contrast}>
            {[0, 1].map((side) => (
              <td key={side} class="number">
                {share(numbers?.contrast[side as 0 | 1], 3)}
              </td>
            ))}
          </Row>
          <Row title="Mean difference" how={HOW.mean}>
            <td class="number" colSpan={2}>
              {share(numbers?.mean_difference, 3)}
            </td>
          </Row>
          <Row title="Largest difference" how={HOW.most}>
            <td colSpan={2}>
              <button
                type="button"
                class="compare-mark"
                disabled={!numbers?.max_at}
                onClick={() => numbers?.max_at && onGo(numbers.max_at)}
              >
                {share(numbers?.max_difference, 3)}
              </button>
            </td>
          </Row>
        </tbody>
      </table>
    </div>
  );
}

function Row({
  title,
  how,
  children,
}: {
  readonly title: string;
  readonly how: string;
  readonly children: ComponentChildren;
}) {
  return (
    <tr>
      <th scope="row">
        {title}
        <About text={how} about={title} />
      </th>
      {children}
    </tr>
  );
}

function About({ text, about }: { readonly text: string; readonly about: string }) {
  return <Tooltip text={text} about={about} id={useId()} />;
}

interface MarkProps {
  readonly comparison: Comparison;
  readonly marked: Marked;
  readonly count: number | undefined;
  readonly about: string;
  readonly quiet: boolean;
}

/** A count of cells; when pressed, the cells are marked in the picture. */
function Mark({ comparison, marked, count: n, about, quiet }: MarkProps) {
  const now = comparison.marked.value;
  const isOn = JSON.stringify(now) === JSON.stringify(marked);
  return (
    <button
      type="button"
      class={`compare-mark${quiet ? " same" : ""}`}
      aria-pressed={isOn}
      aria-label={`${count(n)} cells ${about}`}
      disabled={!n && !isOn}
      onClick={() => {
        comparison.marked.value = isOn ? null : marked;
      }}
    >
      {count(n)}
    </button>
  );
}
