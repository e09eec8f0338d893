import { useEffect, useMemo } from "preact/hooks";
import { shownTime } from "../../store/shownTime";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { isTyping } from "../../ui/browser/isTyping";
import { Select } from "../../ui/Select";
import { Timeline, type TimelineMark } from "../../ui/Timeline";
import type { LogEvent } from "../../wire/http";
import type { Trajectory } from "../../wire/protocol";
import { eventLabel } from "./Doctor";
import { type LinesState, ticksOf } from "./lines/lines";
import { goToNote } from "./notes/Notes";
import { scanOf } from "./notes/noteRecords";
import type { NotesState } from "./notes/useNotes";
import type { TimelinePlotsState } from "./plots/timelinePlots";
import { Moment } from "./time/Moment";
import { scansAt, secondsAt } from "./time/scanTimes";

const SPEEDS = [0.1, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000];

/** The speeds to choose from: round values within the session's limits, and the current one. */
function speeds(now: number, [low, high]: readonly [number, number]): readonly number[] {
  const round = SPEEDS.filter((speed) => speed >= low && speed <= high);
  return [...new Set([...round, now])].sort((a, b) => a - b);
}

/** The notes that have a time, for the seek bar. */
function marksOf(state: NotesState | undefined, trajectory: Trajectory | null, count: number): TimelineMark[] {
  return (state?.notes.value ?? []).flatMap((note) => {
    const index = scanOf(note, trajectory, count);
    return index === null
      ? []
      : [{ id: note.id, index, label: `Note: ${note.text}`, chosen: state?.chosen.value === note.id, kind: "note" }];
  });
}

const EVENT = "event ";

/** The events of the log, for the seek bar; their ids are their scans. */
const eventMarks = (store: Store, events: readonly LogEvent[]): TimelineMark[] =>
  events.map((event) => ({
    id: `${EVENT}${event.scan + 1}`,
    index: event.scan + 1,
    label: `${eventLabel(event)}, ${shownTime(store, event.seconds)}`,
    chosen: false,
    kind: "event",
  }));

interface TransportProps {
  readonly store: Store;
  /** The unit of one step. */
  readonly unit?: string;
  readonly notes?: NotesState;
  /** Called when a note's mark was pressed. */
  readonly onNote?: () => void;
  readonly events?: readonly LogEvent[];
  readonly lines?: LinesState;
  /** The plots below it, for a log of scans. */
  readonly plots?: TimelinePlotsState;
}

/** Playback of the log: play, step, seek, speed. */
export function Transport({ store, unit = "scan", notes, onNote, events = [], lines, plots }: TransportProps) {
  const frame = store.frame.value;
  const hello = store.hello.value;
  const playing = frame?.playing ?? false;
  useEffect(() => {
    const onKey = (event: KeyboardEvent): void => {
      if (event.key !== " " || isTyping(event.target)) return;
      event.preventDefault();
      store.togglePlaying();
    };
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, [store]);

  const count = frame?.count ?? 0;
  const index = frame?.index ?? 0;
  const duration = hello?.log?.duration_s ?? 0;
  const trajectory = store.trajectory.value;
  const timeAt =
    duration > 0 && trajectory ? (at: number): string => shownTime(store, secondsAt(trajectory, at)) : undefined;
  const span = duration > 0 ? plots?.zoom.value : null;
  const logged = lines?.lines.value;
  const ticks = useMemo(
    () => (logged && trajectory ? ticksOf(logged, trajectory, count) : []),
    [logged, trajectory, count],
  );
  const speed = frame?.speed ?? 1;
  return (
    <section class="viewer-transport" aria-label="Playback">
      <Button
        kind="primary"
        icon={playing ? "pause" : index >= count && count > 0 ? "restart" : "play"}
        label={playing ? "Pause" : index >= count && count > 0 ? "Play again" : "Play"}
        disabled={!frame}
        onClick={() => store.togglePlaying()}
      />
      <Button
        icon="stepBack"
        label={`Back one ${unit}`}
        disabled={!frame}
        onClick={() => store.send({ type: "step", scans: -1 })}
      />
      <Button
        icon="stepForward"
        label={`Forward one ${unit}`}
        disabled={!frame}
        onClick={() => store.send({ type: "step", scans: 1 })}
      />
      <Timeline
        index={index}
        count={count}
        timeAt={timeAt}
        onSeek={(to) => store.sendSoon({ type: "seek", index: to })}
        pointed={plots?.inPlots.value ?? null}
        onPoint={(at) => {
          if (plots) plots.onTimeline.value = at;
        }}
        ticks={ticks}
        band={span && trajectory ? [scansAt(trajectory, span[0], count), scansAt(trajectory, span[1], count)] : null}
        marks={[...marksOf(notes, trajectory, count), ...eventMarks(store, events)]}
        onMark={(id) => {
          if (id.startsWith(EVENT)) store.goTo(Number(id.slice(EVENT.length)));
          const note = notes?.notes.peek()?.find((note) => note.id === id);
          if (!notes || !note) return;
          onNote?.();
          goToNote(store, notes, note);
        }}
      />
      <div class="viewer-position">
        <output aria-live="off" data-index={index} data-count={count}>
          {index} of {count}
        </output>
        {duration > 0 && frame && <Moment store={store} seconds={frame.stamp} duration={duration} />}
      </div>
      <label class="speed">
        <span class="visually-hidden">Speed</span>
        <Select
          disabled={!frame}
          value={String(speed)}
          options={speeds(speed, hello?.speeds ?? [0.1, 100]).map((value) => ({
            value: String(value),
            label: `${value}×`,
          }))}
          onChange={(value) => store.send({ type: "speed", value: Number(value) })}
        />
      </label>
      {plots && (
        <Button
          icon="curve"
          pressed={plots.isOpen.value}
          disabled={!frame}
          onClick={() => {
            plots.isOpen.value = !plots.isOpen.peek();
          }}
        >
          <span class="plots-word">Plots</span>
        </Button>
      )}
    </section>
  );
}
