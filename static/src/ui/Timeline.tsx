import { useSignal } from "@preact/signals";
import { useId, useRef } from "preact/hooks";
import { indexAt, keyedIndex, placeOf } from "./seek";

/** A place on the seek bar with a text. */
export interface TimelineMark {
  readonly id: string;
  readonly index: number;
  readonly label: string;
  readonly chosen: boolean;
  /** What it marks: a place above the bar for a note, below it for the rest. */
  readonly kind: "note" | "event";
}

/** A place on the seek bar without a text, which cannot be pressed. */
export interface TimelineTick {
  readonly index: number;
  readonly isGrave: boolean;
}

interface TimelineProps {
  readonly index: number;
  readonly count: number;
  /** The recorded time at an index, where the log has times. */
  readonly timeAt?: ((index: number) => string) | undefined;
  readonly onSeek: (index: number) => void;
  /** The index that is pointed at in another view of the same time. */
  readonly pointed?: number | null;
  /** Called with the index under the pointer, null when it leaves. */
  readonly onPoint?: (index: number | null) => void;
  readonly marks?: readonly TimelineMark[];
  readonly ticks?: readonly TimelineTick[];
  /** The interval that plots of the same time show. */
  readonly band?: readonly [from: number, to: number] | null;
  /** Called with the id of a mark that was pressed. */
  readonly onMark?: (id: string) => void;
}

/** Horizontal distance of a touch before it drags, px: until then it may become a scroll of the page. */
const SLOP_TOUCH = 6;

/** A seek bar over scans. While it is dragged the thumb follows the pointer, not the position of the server. */
export function Timeline({ marks = [], ticks = [], band = null, onMark, ...bar }: TimelineProps) {
  return (
    <div class="timeline-place">
      <SeekBar {...bar} />
      {band && (
        <span
          class="timeline-band"
          aria-hidden="true"
          style={{
            left: `${placeOf(band[0], bar.count) * 100}%`,
            right: `${100 - placeOf(band[1], bar.count) * 100}%`,
          }}
        />
      )}
      {ticks.map(({ index, isGrave }) => (
        <span
          key={index}
          class={isGrave ? "timeline-tick grave" : "timeline-tick"}
          aria-hidden="true"
          style={{ left: `${placeOf(index, bar.count) * 100}%` }}
        />
      ))}
      {marks.map((mark) => (
        <button
          key={mark.id}
          type="button"
          class={`timeline-${mark.kind === "note" ? "mark" : mark.kind} ${mark.chosen ? "chosen" : ""}`}
          style={{ left: `${placeOf(mark.index, bar.count) * 100}%` }}
          aria-label={mark.label}
          title={mark.label}
          onClick={() => onMark?.(mark.id)}
        />
      ))}
    </div>
  );
}

function SeekBar({
  index,
  count,
  timeAt,
  onSeek,
  pointed = null,
  onPoint,
}: Omit<TimelineProps, "marks" | "ticks" | "band" | "onMark">) {
  const id = useId();
  const track = useRef<HTMLDivElement>(null);
  const dragged = useSignal<number | null>(null);
  const touched = useRef<number | null>(null); // start of a touch that does not drag yet
  const hovered = useSignal<number | null>(null);
  const shown = dragged.value ?? index;
  const place = placeOf(shown, count);
  const label = (at: number): string => `scan ${at}${timeAt ? ` · ${timeAt(at)}` : ""}`;
  const preview = dragged.value ?? hovered.value ?? pointed;

  const at = (event: PointerEvent): number => {
    const box = track.current?.getBoundingClientRect();
    return box ? indexAt(event.clientX - box.left, box.width, count) : 0;
  };
  const drag = (event: PointerEvent): void => {
    const next = at(event);
    if (next === dragged.peek()) return;
    dragged.value = next;
    onSeek(next);
  };
  const press = (event: PointerEvent): void => {
    track.current?.setPointerCapture(event.pointerId);
    if (event.pointerType === "touch") touched.current = event.clientX;
    else drag(event);
  };
  const move = (event: PointerEvent): void => {
    hovered.value = event.pointerType === "mouse" ? at(event) : null;
    onPoint?.(hovered.value);
    const begins = touched.current !== null && Math.abs(event.clientX - touched.current) > SLOP_TOUCH;
    if (begins) touched.current = null;
    if (begins || dragged.peek() !== null) drag(event);
  };
  const release = (event: PointerEvent): void => {
    if (touched.current !== null) drag(event); // a tap
    stop();
  };
  const stop = (): void => {
    touched.current = null;
    dragged.value = null;
  };

  return (
    <div
      ref={track}
      class="timeline"
      role="slider"
      tabIndex={0}
      aria-label="Scans in the map"
      aria-describedby={id}
      aria-valuemin={0}
      aria-valuemax={count}
      aria-valuenow={shown}
      aria-valuetext={`scan ${shown} of ${count}${timeAt ? `, at ${timeAt(shown)}` : ""}`}
      onPointerDown={press}
      onPointerMove={move}
      onPointerUp={release}
      onPointerCancel={stop}
      onPointerLeave={() => {
        hovered.value = null;
        onPoint?.(null);
      }}
      onKeyDown={(event) => {
        const next = keyedIndex(event.key, event.shiftKey, shown, count);
        if (next === null) return;
        event.preventDefault();
        onSeek(next);
      }}
    >
      <span id={id} hidden>
        Number of scans of the log that are in the map; later scans are left out.
      </span>
      <div class="timeline-track">
        <div class="timeline-done" style={{ transform: `scaleX(${place})` }} />
      </div>
      <div class="timeline-thumb" style={{ left: `${place * 100}%` }} />
      {preview !== null && (
        <div class="timeline-preview" style={{ left: `${Math.min(92, Math.max(8, placeOf(preview, count) * 100))}%` }}>
          {label(preview)}
        </div>
      )}
    </div>
  );
}
