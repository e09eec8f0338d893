import { useId } from "preact/hooks";
import { useDrag } from "./browser/useDrag";
import { decimals, keyed, type Range, snap, written } from "./numbers";
import type { Tone } from "./Slider";

interface DragNumberProps extends Range {
  readonly label: string;
  /** One sentence on what it does. */
  readonly sentence: string;
  readonly value: number;
  readonly unit?: string;
  readonly tone?: Tone;
  /** Its text; by default the value with fixed decimals and the unit. */
  readonly text?: string;
  /** Punctuation that must stay on the same line. */
  readonly after?: string;
  readonly onInput: (value: number) => void;
}

const PX_PER_STEP = 6;

/** A number in a sentence that can be dragged sideways, or moved by the arrow keys. After Bret Victor's Tangle. */
export function DragNumber(props: DragNumberProps) {
  const { label, sentence, value, unit, tone = "accent", text, low, high, step, after, onInput } = props;
  const id = useId();
  const range = { low, high, step };
  const shown = text ?? `${written(value, decimals(step))}${unit ? ` ${unit}` : ""}`;
  const drag = useDrag({
    begin: () => value,
    move: (from, dx) => {
      const next = snap(from + (dx / PX_PER_STEP) * step, range);
      if (next !== value) onInput(next);
    },
  });
  const number = (
    <span
      class={`drag-number tone-${tone}`}
      role="slider"
      tabIndex={0}
      aria-label={label}
      aria-valuenow={value}
      aria-valuemin={low}
      aria-valuemax={high}
      aria-valuetext={shown}
      aria-describedby={id}
      title={`${label}: drag sideways, or use the arrow keys. ${sentence}`}
      {...drag}
      onKeyDown={(event) => {
        const next = keyed(event.key, event.shiftKey, value, range);
        if (next === null) return;
        event.preventDefault();
        if (next !== value) onInput(next);
      }}
    >
      {shown}
    </span>
  );
  return (
    <span class="drag-number-phrase">
      {number}
      <span id={id} hidden>
        {sentence}
      </span>
      {after}
    </span>
  );
}
