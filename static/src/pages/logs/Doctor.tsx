import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { momentText, shownTime } from "../../store/shownTime";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { whenIdle } from "../../ui/browser/whenIdle";
import { Icon } from "../../ui/Icon";
import { signed, written } from "../../ui/numbers";
import { ProgressBar } from "../../ui/ProgressBar";
import { progressText } from "../../ui/Working";
import { ask } from "../../wire/ask";
import { DOCTOR_LEAST_SCANS } from "../../wire/constants";
import type { DoctorAnswer, FindingAnswer, LogEvent } from "../../wire/http";
import type { LogInfo, Point } from "../../wire/protocol";
import { followMaking, type Making, newName } from "../making";
import { SENSOR_SEPARATOR, trajectoryLabel } from "./library/describeLog";
import "./doctor.css";

/** Whether several poses are all at the same place. */
export function standsStill(poses: readonly Point[]): boolean {
  const first = poses[0];
  return first !== undefined && poses.length > 1 && poses.every(([x, y]) => x === first[0] && y === first[1]);
}

/**
 * Whether the server certainly examines a log: it refuses a log in which no sensor has enough scans. The numbers of the
 * single sensors are not known here, but the greatest is at least their mean.
 */
export function isLongEnough(log: Pick<LogInfo, "n_scans" | "topic"> | null): boolean {
  return log !== null && log.n_scans >= DOCTOR_LEAST_SCANS * log.topic.split(SENSOR_SEPARATOR).length;
}

/**
 * Examine the log of a session. `show` is called with the progress, and `signal` aborts it.
 *
 * Rejects with the server's sentence if it is refused.
 */
export function examine(
  session: string,
  show: (making: Making | null) => void,
  signal: AbortSignal,
): Promise<DoctorAnswer> {
  const name = newName();
  const stop = followMaking(name, show);
  const options = { query: { name }, ending: signal };
  return ask("GET /api/sessions/{session_id}/doctor", { session_id: session }, options).finally(stop);
}

/**
 * The sentence for an examination without findings. For poses without motion it says only that, because drift, delay
 * and mount are judged from readings at different places.
 */
export function wellLabel(poses: string, stands: boolean): readonly [result: string, about: string] {
  if (!stands) return ["No problems found.", `Poses: ${poses}.`];
  return ["No problems found in the readings.", "The poses do not move, so drift, delay and mount cannot be checked."];
}

/** The certainty of a finding as text. */
export function confidenceLabel({ sure, possible }: Pick<FindingAnswer, "sure" | "possible">): string {
  if (possible) return "possible";
  if (sure >= 0.95) return "certain";
  return sure >= 0.8 ? "very likely" : "likely";
}

type State =
  | { readonly kind: "idle" }
  | { readonly kind: "busy" }
  | { readonly kind: "cancelled" }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "done"; readonly examination: DoctorAnswer };

const IDLE_MS = 2000;
const LASTS_S = 1; // a longer event is shown with its end
const FIRST_NOTES = 3; // number of notes shown without unfolding

const CHECKED =
  "the clock, readings at max range, beams that hit the robot, the mount of the sensor, the delay between scans and " +
  "poses, drift, moving objects, and events: pushes, slips, lifts, steps of the clock, and gaps";

/** The examination of a log, which continues while the doctor's group is closed. */
export interface DoctorState {
  readonly state: Signal<State>;
  /** Progress of an examination; null if there is none, or before it is known. */
  readonly progress: Signal<Making | null>;
  readonly run: () => Promise<void>;
  readonly cancel: () => void;
}

/**
 * The examination starts when the page is idle; that of a guest and that of a very short log start with the button. A
 * guest has the findings of the link's sender: `given`.
 */
export function useDoctor(
  store: Store,
  session: string,
  isGuest: boolean,
  given: DoctorAnswer | null = null,
): DoctorState {
  const state = useSignal<State>(given ? { kind: "done", examination: given } : { kind: "idle" });
  const progress = useSignal<Making | null>(null);
  const cancelledOf = useRef<string | undefined>(undefined); // the trajectory whose examination was cancelled
  useSignalEffect(() => {
    // Another trajectory needs a new examination.
    const now = store.trajectory.value?.name;
    const before = state.peek();
    if (before.kind === "cancelled" && now !== cancelledOf.current) state.value = { kind: "idle" };
    if (before.kind === "done" && now !== undefined && now !== before.examination.trajectory) {
      state.value = { kind: "idle" };
    }
  });
  useSignalEffect(() => {
    const isToDo = state.value.kind === "idle" && store.trajectory.value !== null && !isGuest;
    return isToDo && isLongEnough(store.hello.peek()?.log ?? null) ? whenIdle(IDLE_MS, () => void run()) : undefined;
  });
  const ending = useRef<AbortController | null>(null);
  const run = async (): Promise<void> => {
    const own = new AbortController();
    ending.current = own;
    state.value = { kind: "busy" };
    try {
      const show = (making: Making | null): void => {
        progress.value = making;
      };
      const examination = await examine(session, show, own.signal);
      const isOfNow = examination.trajectory === store.trajectory.peek()?.name;
      state.value = isOfNow ? { kind: "done", examination } : { kind: "idle" };
    } catch (error) {
      if (own.signal.aborted) return;
      state.value = { kind: "failed", why: (error as Error).message };
    }
  };
  const cancel = (): void => {
    cancelledOf.current = store.trajectory.peek()?.name;
    state.value = { kind: "cancelled" };
    ending.current?.abort();
  };
  return { state, progress, run, cancel };
}

/** The number of findings and events for the doctor's tab; null if none are known. */
export function findingsBadge({ state }: DoctorState): string | null {
  const now = state.value;
  if (now.kind !== "done") return null;
  const count = now.examination.findings.length + now.examination.events.length;
  return count > 0 ? String(count) : null;
}

/** The events of an examined log. */
export function eventsOf({ state }: DoctorState): readonly LogEvent[] {
  return state.value.kind === "done" ? state.value.examination.events : [];
}

/** The check whose finding SLAM corrects. */
const DRIFT = "walls.drift";

/** Whether the examination found that the poses in use drift. */
export function findsDrift({ state }: DoctorState): boolean {
  const now = state.value;
  return now.kind === "done" && now.examination.findings.some(({ check, possible }) => check === DRIFT && !possible);
}

interface DoctorProps {
  readonly store: Store;
  readonly doctor: DoctorState;
  /** Corrects the poses of the log; not for a guest. */
  readonly onCorrectPoses?: () => void;
}

/** The log doctor: the events of a log, its problems with place, certainty and remedy. */
export function Doctor({ store, doctor: { state, progress, run, cancel }, onCorrectPoses }: DoctorProps) {
  const now = state.value;
  const hasEvents = now.kind === "done" && now.examination.events.length > 0;
  const isWell = now.kind === "done" && now.examination.findings.length === 0 && !hasEvents;
  const stands = standsStill(store.trajectory.value?.poses ?? []);
  const [result, about] = isWell ? wellLabel(trajectoryLabel(now.examination.trajectory), stands) : ["", ""];
  const findings = now.kind === "done" ? now.examination.findings : [];
  return (
    <section class="doctor" aria-label="Log doctor">
      <div class="doctor-result" role="status">
        {isWell && (
          <p class="doctor-well">
            <Icon name="check" />
            <span>
              <b>{result}</b> {about}
            </span>
          </p>
        )}
        {hasEvents && <Events events={now.examination.events} store={store} />}
        {findings.length > 0 && (
          <section aria-label="Findings">
            <h2 class="doctor-title">Findings</h2>
            <ul class="findings">
              {findings.map((finding) => (
                <FindingItem
                  key={`${finding.check} ${finding.sensor}`}
                  finding={finding}
                  store={store}
                  {...(onCorrectPoses ? { onCorrectPoses } : {})}
                />
              ))}
            </ul>
          </section>
        )}
        {now.kind !== "done" && now.kind !== "busy" && (
          <Button icon="target" onClick={() => void run()}>
            Examine this log
          </Button>
        )}
        {now.kind === "cancelled" && <p class="quiet">Cancelled.</p>}
        {now.kind === "busy" && <ExaminationProgress progress={progress.value} cancel={cancel} />}
        {now.kind === "failed" && <p class="failure">{now.why}</p>}
      </div>
      <Notes notes={store.hello.value?.log?.notes ?? []} />
      {!hasEvents && findings.length === 0 && <p class="quiet">Checks {CHECKED}.</p>}
    </section>
  );
}

/** Kinds of events as a word. */
const EVENTS: Readonly<Record<LogEvent["kind"], string>> = {
  pushed: "Pushed",
  slipped: "Slipped",
  lifted: "Lifted",
  clock: "Clock set",
  gap: "Gap",
};

/**
 * The distance that an event moved the robot, the change of the clock, or the duration, in a word or two; "" if
 * unknown.
 */
export function measureOf(event: LogEvent): string {
  const { kind, distance_m, direction, turned_rad } = event;
  if (kind === "clock") return `${signed(event.step_s, 2)} s`;
  if (kind === "gap") return `${written(event.until_s - event.seconds, 2)} s`;
  if (distance_m === null) return "";
  if (kind === "slipped") return `${written(distance_m, 2)} m`; // of its wheels, not of the robot
  if (direction === null && turned_rad !== null) return `${written((Math.abs(turned_rad) * 180) / Math.PI, 0)}°`;
  return [`${written(distance_m, 2)} m`, direction].filter(Boolean).join(" ");
}

/** An event in a few words. */
export const eventLabel = (event: LogEvent): string => [EVENTS[event.kind], measureOf(event)].filter(Boolean).join(" ");

/** An event as a sentence; its start is on the button beside it. */
function sentenceOf(store: Store, { what, seconds, until_s }: LogEvent): string {
  if (until_s - seconds > LASTS_S) return `Until ${shownTime(store, until_s)} ${what}`;
  return what.charAt(0).toUpperCase() + what.slice(1);
}

/** The events during the recording, each with a button that goes to the scan before it. */
export function Events({ events, store }: { readonly events: readonly LogEvent[]; readonly store: Store }) {
  return (
    <section class="events" aria-label="Events">
      <h2 class="doctor-title">Events</h2>
      <ul>
        {events.map((event) => (
          <li key={`${event.kind} ${event.seconds}`} data-event={event.kind}>
            <TimeButton store={store} seconds={event.seconds} scan={event.scan} />
            <p>
              <span class="finding-sure">
                {EVENTS[event.kind]} <span class="number">{measureOf(event)}</span>
              </span>
              <span class="quiet">{sentenceOf(store, event)}</span>
            </p>
          </li>
        ))}
      </ul>
    </section>
  );
}

interface TimeButtonProps {
  readonly store: Store;
  readonly seconds: number;
  /** Number of the scan at that time, from 0. */
  readonly scan: number;
}

/** A moment as a button that goes there; for a log without times, the number of the scan. */
function TimeButton({ store, seconds, scan }: TimeButtonProps) {
  const text = momentText(store, seconds, scan + 1);
  return (
    <Button kind="quiet" label={`Go to ${text}`} onClick={() => store.goTo(scan + 1)}>
      <span class="number">{text}</span>
    </Button>
  );
}

interface ProgressProps {
  readonly progress: Making | null;
  readonly cancel: () => void;
}

/** As high as the button that it replaces: an examination starts by itself, and nothing must move then. */
function ExaminationProgress({ progress, cancel }: ProgressProps) {
  return (
    <div class="doctor-progress">
      <ProgressBar fraction={progress?.fraction ?? null} />
      <span class="quiet">
        Examining …{" "}
        <span class="number" aria-hidden="true">
          {progress && progressText(progress)}
        </span>
      </span>
      <Button kind="quiet" label="Cancel the examination" onClick={cancel}>
        Cancel
      </Button>
    </div>
  );
}

/** Notes of the reader of the log. */
function Notes({ notes }: { readonly notes: readonly string[] }) {
  if (notes.length === 0) return null;
  const rest = notes.slice(FIRST_NOTES);
  return (
    <div class="doctor-notes">
      {notes.slice(0, FIRST_NOTES).map((note) => (
        <p key={note}>{note}</p>
      ))}
      {rest.length > 0 && (
        <details>
          <summary>{rest.length} more</summary>
          {rest.map((note) => (
            <p key={note}>{note}</p>
          ))}
        </details>
      )}
    </div>
  );
}

interface FindingProps {
  readonly finding: FindingAnswer;
  readonly store: Store;
  readonly onCorrectPoses?: () => void;
}

const MOST_MOMENTS = 6;

/** The moments that show a finding best, in the order of time. */
export function momentsOf({ scans, seconds }: Pick<FindingAnswer, "scans" | "seconds">) {
  const best = scans.slice(0, MOST_MOMENTS).map((scan, n) => ({ scan, seconds: seconds[n] ?? 0 }));
  return best.sort((a, b) => a.scan - b.scan);
}

function FindingItem({ finding, store, onCorrectPoses }: FindingProps) {
  const { parameters } = finding;
  const values = store.mapping.values.value;
  const tried = parameters !== null && Object.entries(parameters).every(([name, value]) => values[name] === value);
  return (
    <li class="finding" data-check={finding.check}>
      <p>
        <span class="finding-sure">{confidenceLabel(finding)}</span>{" "}
        {finding.sensor && <strong class="finding-sensor">{finding.sensor}: </strong>}
        {finding.sentence}
      </p>
      <p class="quiet">{finding.advice}</p>
      <div class="finding-actions">
        {finding.check === DRIFT && onCorrectPoses && (
          <Button kind="primary" onClick={onCorrectPoses}>
            Heal its poses
          </Button>
        )}
        {parameters && (
          <Button disabled={tried} onClick={() => store.setTogether(`doctor ${finding.check}`, parameters)}>
            {tried ? "Applied to the map" : "Apply to the map"}
          </Button>
        )}
        {momentsOf(finding).map(({ scan, seconds }) => (
          <TimeButton key={scan} store={store} seconds={seconds} scan={scan} />
        ))}
      </div>
    </li>
  );
}
