import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { readable } from "../../tools/parameters/parameters";
import { Button } from "../../ui/Button";
import { Icon } from "../../ui/Icon";
import { decimals, written } from "../../ui/numbers";
import { Panel } from "../../ui/Panel";
import { toast } from "../../ui/Toast";
import type { Attempt, OfferedPuzzle } from "../../wire/http";
import { resultText } from "./attempt";

function textOf(value: boolean | number | string): string {
  if (typeof value === "boolean") return value ? "on" : "off";
  return typeof value === "number" ? written(value, decimals(Math.abs(value))) : readable(value);
}

interface AnswerProps {
  readonly store: Store;
  readonly attempt: Attempt;
  readonly onClose: (() => void) | undefined;
  readonly next: OfferedPuzzle | null;
  readonly onNext: (name: string) => void;
}

/** The end of an attempt: the cause, what repairs the map, and where to go on. */
export function Answer({ store, attempt, onClose, next, onNext }: AnswerProps) {
  const { answer } = attempt;
  const top = useRef<HTMLDivElement>(null);
  // The settings that solved the puzzle may have been far down in the panel.
  useEffect(() => top.current?.scrollIntoView({ block: "nearest" }), []);
  if (!answer) return null;
  const rows = store.hello.value?.parameters.table ?? [];
  const said = Object.entries(answer.repair).map(([name, value]) => {
    const row = rows.find((one) => one.name === name);
    return `${row?.label ?? name} ${textOf(value)}${row?.unit ? ` ${row.unit}` : ""}`;
  });
  if (answer.trajectory) said.push(`poses from ${answer.trajectory}`);
  const repair = (): void => {
    if (Object.keys(answer.repair).length > 0) store.setTogether("repair", answer.repair);
    if (answer.trajectory) store.send({ type: "trajectory", name: answer.trajectory });
  };
  return (
    <div ref={top} class="case-answer">
      <Panel title={attempt.is_solved ? `Solved: ${attempt.points} of 100 points` : "The answer"}>
        <p class="case-right" role="status">
          <Icon name={attempt.is_solved ? "check" : "info"} /> {answer.label}.
        </p>
        <p>{answer.explanation}</p>
        <p class="case-lesson">
          The lecture says: <q>{answer.lesson}</q>
        </p>
        {said.length > 0 && <p class="quiet">A repair: {said.join(", ")}.</p>}
        <div class="actions">
          {!attempt.is_solved && said.length > 0 && (
            <Button kind="primary" onClick={repair}>
              Repair the map
            </Button>
          )}
          {next && (
            <Button kind={attempt.is_solved ? "primary" : undefined} onClick={() => onNext(next.name)}>
              Next: {next.title}
            </Button>
          )}
          <Button href={`/lecture.html#${answer.section}`} target="_blank">
            Its section of the lecture
          </Button>
          {attempt.is_solved && (
            <Button onClick={() => void copy(resultText(attempt, location.href))}>Copy the result</Button>
          )}
          {onClose && <Button onClick={onClose}>All puzzles</Button>}
        </div>
      </Panel>
    </div>
  );
}

async function copy(text: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    toast("Copied: your points, and the address of the puzzle.");
  } catch {
    toast(text); // the browser forbids it: the text can be selected
  }
}
