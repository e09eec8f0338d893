import { useSignal } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import { inUtc, shownStart } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { readTime, timeText } from "../../../ui/text/timeText";
import { scansAt } from "./scanTimes";
import "./moment.css";

interface MomentProps {
  readonly store: Store;
  /** Recorded time at the newest scan in the map, and of the whole log, s. */
  readonly seconds: number;
  readonly duration: number;
}

/**
 * The present time of the log as a button that opens a field for another time, with the switch between recorded time
 * and UTC.
 */
export function Moment({ store, seconds, duration }: MomentProps) {
  const isAsking = useSignal(false);
  const start = shownStart(store);
  const text = timeText(seconds, start);
  const hasUtc = (store.hello.value?.log?.start_s ?? null) !== null;
  return (
    <span class="moment">
      {isAsking.value ? (
        <TimeField
          store={store}
          text={text}
          onDone={() => {
            isAsking.value = false;
          }}
        />
      ) : (
        <button
          type="button"
          class="moment-time number"
          title={`${text} of ${timeText(duration)}: go to a time`}
          aria-label={`${start === null ? `${text} of ${timeText(duration)}` : text}: go to a time`}
          onClick={() => {
            isAsking.value = true;
          }}
        >
          {start === null ? text : text.slice(11)}
          {start === null && <span class="moment-whole"> of {timeText(duration)}</span>}
        </button>
      )}
      {hasUtc && <UtcSwitch />}
    </span>
  );
}

/** Whether times are in UTC on the whole page. */
export function UtcSwitch({ label = "UTC" }: { readonly label?: string }) {
  return (
    <button
      type="button"
      class="moment-utc"
      role="switch"
      aria-checked={inUtc.value}
      title="Times in UTC, or since the first scan"
      onClick={() => {
        inUtc.value = !inUtc.peek();
      }}
    >
      {label}
    </button>
  );
}

interface TimeFieldProps {
  readonly store: Store;
  readonly text: string;
  readonly onDone: () => void;
}

function TimeField({ store, text, onDone }: TimeFieldProps) {
  const id = useId();
  const field = useRef<HTMLInputElement>(null);
  const isWrong = useSignal(false);
  useEffect(() => field.current?.select(), []);
  const go = (): void => {
    const trajectory = store.trajectory.peek();
    const seconds = readTime(field.current?.value ?? "", store.hello.peek()?.log?.start_s ?? null);
    isWrong.value = seconds === null;
    if (seconds === null || !trajectory) return;
    store.goTo(scansAt(trajectory, seconds, store.frame.peek()?.count ?? 0));
    onDone();
  };
  return (
    <form
      class="moment-form"
      onSubmit={(event) => {
        event.preventDefault();
        go();
      }}
    >
      <input
        ref={field}
        class="field-text number"
        aria-label="Time to go to"
        aria-invalid={isWrong.value}
        {...(isWrong.value ? { "aria-describedby": id } : {})}
        defaultValue={text}
        onBlur={onDone}
        onKeyDown={(event) => {
          if (event.key === "Escape") onDone();
        }}
      />
      {isWrong.value && (
        <span class="moment-wrong" id={id} role="alert">
          Write 73.4, 1:13.4 or 08:54:33.4 UTC.
        </span>
      )}
    </form>
  );
}
