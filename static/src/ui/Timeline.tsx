import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { indexAt, keyedIndex, placeOf } from "./seek";

interface TimelineProps {
  readonly index: number;
  readonly count: number;
  /** The recorded time at an index, where the log has times. */
  readonly timeAt?: ((index: number) => string) | undefined;
  readonly onSeek: (index: number) => void;
}

/** A seek bar over scans. While it is dragged the thumb stays under the finger, whatever the server has reached. */
export function Timeline({ index, count, timeAt, onSeek }: TimelineProps) {
  const track = useRef<HTMLDivElement>(null);
  const dragged = useSignal<number | null>(null);
  const hovered = useSignal<number | null>(null);
  const shown = dragged.value ?? index;
  const place = placeOf(shown, count);
  const label = (at: number): string => `scan ${at}${timeAt ? ` · ${timeAt(at)}` : ""}`;
  const preview = dragged.value ?? hovered.value;

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
  const release = (): void => {
    dragged.value = null;
  };

  return (
    <div
      ref={track}
      class="timeline"
      role="slider"
      tabIndex={0}
      aria-label="Scans in the map"
      aria-valuemin={0}
      aria-valuemax={count}
      aria-valuenow={shown}
      aria-valuetext={`scan ${shown} of ${count}${timeAt ? `, at ${timeAt(shown)}` : ""}`}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        drag(event);
      }}
      onPointerMove={(event) => {
        hovered.value = event.pointerType === "mouse" ? at(event) : null;
        if (dragged.peek() !== null) drag(event);
      }}
      onPointerUp={release}
      onPointerCancel={release}
      onPointerLeave={() => {
        hovered.value = null;
      }}
      onKeyDown={(event) => {
        const next = keyedIndex(event.key, event.shiftKey, shown, count);
        if (next === null) return;
        event.preventDefault();
        onSeek(next);
      }}
    >
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
