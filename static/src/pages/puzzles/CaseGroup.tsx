/** The task: the cause, the progress of the repair, hints, and at the end the explanation. */

import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { ParameterRows } from "../../tools/parameters/ParameterRows";
import { readable } from "../../tools/parameters/parameters";
import { Button } from "../../ui/Button";
import { useAttempts } from "../../ui/browser/attempts";
import { confirm } from "../../ui/Dialog";
import { Failure } from "../../ui/Failure";
import { Icon } from "../../ui/Icon";
import { decimals, written } from "../../ui/numbers";
import { Panel } from "../../ui/Panel";
import { toast } from "../../ui/Toast";
import type { Attempt, OfferedPuzzle, SolutionAnswer } from "../../wire/http";
import { compareWith, endComparison } from "../logs/compare/sides";
import { TrajectoryChoice } from "../logs/trajectories/TrajectoryChoice";
import { MEASURE_NAMES, type Measure, percent, progressText, resultText } from "./attempt";
import { nameCause, step as stepOf } from "./puzzles";

function textOf(value: boolean | number | string): string {
  if (typeof value === "boolean") return value ? "on" : "off";
  return typeof value === "number" ? written(value, decimals(Math.abs(value))) : readable(value);
}

interface AnswerProps {
  readonly session: string;
  readonly store: Store;
  readonly attempt: Attempt;
  readonly onClose: (() => void) | undefined;
  readonly next: OfferedPuzzle | null;
  readonly onNext: (name: string) => void;
}

/** The end of an attempt: the cause, the repair of the map, and links to continue. */
export function Answer({ session, store, attempt, onClose, next, onNext }: AnswerProps) {
  const { answer } = attempt;
  const top = useRef<HTMLDivElement>(null);
  // The control that solved the puzzle may be far down in the panel, which on a phone is lower than the answer is high.
  useEffect(() => top.current?.scrollIntoView({ block: "start" }), []);
  if (!answer) return null;
  const rows = store.hello.value?.parameters.table ?? [];
  const said = Object.entries(answer.repair).map(([name, value]) => {
    const row = rows.find((row) => row.name === name);
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
          {said.length > 0 && <FaultyMap session={session} store={store} answer={answer} />}
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

interface FaultyMapProps {
  readonly session: string;
  readonly store: Store;
  readonly answer: SolutionAnswer;
}

/** Shows the map as it was at first in one half of the picture, beside the present one. */
function FaultyMap({ session, store, answer }: FaultyMapProps) {
  const { failure, attempt } = useAttempts();
  const isShown = store.compared.value !== null;
  const change = (): Promise<void> =>
    attempt(async () => {
      const refused = isShown
        ? await endComparison(session)
        : await compareWith(session, { values: answer.faulty, trajectory: answer.faulty_trajectory });
      if (refused !== null) throw new Error(refused);
    });
  return (
    <>
      <Button pressed={isShown} onClick={() => void change()}>
        Beside the faulty map
      </Button>
      {failure.value && <p role="alert">{failure.value}</p>}
    </>
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

interface CaseProps {
  readonly session: string;
  readonly store: Store;
  readonly attempt: Signal<Attempt | null>;
  readonly openGroup: Signal<string>;
  readonly onCheck: () => void;
  readonly isChecking: boolean;
  readonly onClose: (() => void) | undefined;
  /** An unsolved puzzle to continue with; null for none. */
  readonly next: OfferedPuzzle | null;
  readonly onNext: (name: string) => void;
}

export function CaseGroup(props: CaseProps) {
  const { session, store, attempt, openGroup, onCheck, isChecking, onClose, next, onNext } = props;
  const { failure, attempt: attempted } = useAttempts();
  const answered = useSignal<string | null>(null);
  const now = attempt.value;
  if (!now) return null;
  const step = (work: Promise<Attempt>): Promise<void> =>
    attempted(async () => {
      attempt.value = await work;
    });
  const tool = (id: string, label: string) => (
    <Button
      onClick={() => {
        openGroup.value = id;
      }}
    >
      {label}
    </Button>
  );
  return (
    <div class="case stack">
      {now.answer && (
        <Answer session={session} store={store} attempt={now} onClose={onClose} next={next} onNext={onNext} />
      )}
      {!now.answer && (
        <>
          {now.story && <p class="case-story">{now.story}</p>}
          <div class="actions case-tools">
            <span class="quiet">Look for evidence:</span>
            {tool("why", "Why")}
            {tool("compare", "Compare")}
            {tool("doctor", "Doctor")}
          </div>
        </>
      )}
      <Failure why={failure.value} />
      {!now.answer && (
        <Causes
          attempt={now}
          last={answered.value}
          onAnswer={(cause) => {
            answered.value = cause;
            void step(nameCause(session, cause));
          }}
          key={now.wrong.join()}
        />
      )}
      {now.can_repair !== false && (
        <Repair store={store} attempt={now} onCheck={onCheck} isChecking={isChecking} openGroup={openGroup} />
      )}
      {!now.answer && (
        <Panel title="Help">
          {now.hints.length > 0 && (
            <ol class="case-hints">
              {now.hints.map((hint) => (
                <li key={hint}>{hint}</li>
              ))}
            </ol>
          )}
          <div class="actions">
            <Button disabled={now.hints_left === 0} onClick={() => void step(stepOf(session, "hint"))}>
              {now.hints_left > 0 ? `Show a hint (−${now.costs.hint} points)` : "No more hints"}
            </Button>
            <Button
              kind="quiet"
              onClick={async () => {
                const text = "The attempt ends with 0 points.";
                if (await confirm("Show the answer?", text, "Show the answer")) await step(stepOf(session, "solution"));
              }}
            >
              Show the answer
            </Button>
          </div>
        </Panel>
      )}
    </div>
  );
}

interface CausesProps {
  readonly attempt: Attempt;
  /** Name of the cause that was answered last; null for none. */
  readonly last: string | null;
  readonly onAnswer: (cause: string) => void;
}

function Causes({ attempt, last, onAnswer }: CausesProps) {
  const chosen = useSignal<string | null>(null);
  const wrong = attempt.causes.find(({ name, lesson }) => name === last && lesson !== null);
  if (attempt.is_named) {
    return (
      <p class="case-right" role="status">
        <Icon name="check" /> That is the cause. Now repair the map.
      </p>
    );
  }
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        if (chosen.value) onAnswer(chosen.value);
      }}
    >
      <Panel title="1. What is the cause?">
        <div class="case-causes" role="radiogroup" aria-label="Causes">
          {attempt.causes.map(({ name, label }) => {
            const isWrong = attempt.wrong.includes(name);
            return (
              <label key={name} class={isWrong ? "is-wrong" : ""}>
                <input
                  type="radio"
                  name="cause"
                  value={name}
                  disabled={isWrong}
                  checked={chosen.value === name}
                  onChange={() => {
                    chosen.value = name;
                  }}
                />
                <span>
                  {label}
                  {isWrong && <em> – no</em>}
                </span>
              </label>
            );
          })}
        </div>
        {wrong && (
          <p class="case-wrong" role="status">
            It is not “{wrong.label}”, of which the lecture says: <q>{wrong.lesson}</q> Look for what differs here.
          </p>
        )}
        <div class="actions">
          <Button kind="primary" submits disabled={chosen.value === null}>
            This is the cause
          </Button>
          <span class="quiet" role="status">
            {attempt.wrong.length > 0
              ? `Not the cause: −${attempt.wrong.length * attempt.costs.wrong} points so far.`
              : `A wrong answer costs ${attempt.costs.wrong} points.`}
          </span>
        </div>
      </Panel>
    </form>
  );
}

const MEASURES: readonly (readonly [Measure, string])[] = [
  ["agreement", "Share of walls within 10 cm of where they should be (F-score)"],
  ["sharpness", "Mean difference of p across the edges of walls"],
  ["entropy", "Mean entropy of the observed cells, bits"],
];

/** The repair of the named cause: parameters as controls, or the choice of poses. */
function RepairedWith({ store, attempt }: { readonly store: Store; readonly attempt: Attempt }) {
  const box = useRef<HTMLDivElement>(null);
  const repairs = attempt.answer ? null : attempt.repaired_with;
  const isKnown = repairs !== null && store.hello.value !== null;
  // On a phone it is below the window when the cause is selected.
  useEffect(() => box.current?.scrollIntoView({ block: "nearest" }), [isKnown]);
  const table = store.hello.value?.parameters.table;
  if (!repairs || !table) return null;
  return (
    <div class="stack" ref={box}>
      <ParameterRows
        rows={table.filter(({ name }) => repairs.parameters.includes(name))}
        values={store.mapping.values}
        set={(name, value) => store.setParameter(name, value)}
      />
      {repairs.poses && <TrajectoryChoice store={store} />}
    </div>
  );
}

interface RepairProps {
  readonly store: Store;
  readonly attempt: Attempt;
  readonly onCheck: () => void;
  readonly isChecking: boolean;
  readonly openGroup: Signal<string>;
}

function Repair({ store, attempt, onCheck, isChecking, openGroup }: RepairProps) {
  const { first, now, goal } = attempt;
  return (
    <Panel title="2. Repair the map" note={`solved at ${percent(attempt.enough)}`}>
      {!attempt.answer && (
        <p class="quiet">
          {attempt.repaired_with
            ? "Set this until the map is as it should be, then check it."
            : "Change the settings or the poses until the map is as it should be, then check it."}
        </p>
      )}
      <RepairedWith store={store} attempt={attempt} />
      <table class="case-measures">
        <thead>
          <tr>
            <th scope="col">
              <span class="visually-hidden">Measure</span>
            </th>
            <th scope="col">at first</th>
            <th scope="col">now</th>
            <th scope="col">goal</th>
          </tr>
        </thead>
        <tbody>
          {MEASURES.filter(([name]) => attempt.measures.includes(name)).map(([name, title]) => (
            <tr key={name}>
              <th scope="row" title={title} class="case-measure">
                {MEASURE_NAMES[name]}
              </th>
              <td class="number">{written(first[name], 2)}</td>
              <td class="number">{now ? written(now[name], 2) : "–"}</td>
              <td class="number">{written(goal[name], 2)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p role="status" class="case-repair">
        {progressText(attempt)}
      </p>
      <div class="actions">
        <Button kind={attempt.answer ? undefined : "primary"} disabled={isChecking} onClick={onCheck}>
          {isChecking ? "Checking …" : "Check the map"}
        </Button>
        <Button
          onClick={() => {
            openGroup.value = "settings";
          }}
        >
          Settings
        </Button>
        <Button
          onClick={() => {
            openGroup.value = "poses";
          }}
        >
          Poses
        </Button>
      </div>
    </Panel>
  );
}
