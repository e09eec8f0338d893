import { useSignal } from "@preact/signals";
import { useId, useRef } from "preact/hooks";
import { NumberField } from "./NumberField";
import { fromFraction, keyed, type Range, shownDecimals, snap, toFraction, written } from "./numbers";
import { Tooltip } from "./Tooltip";

export type Tone = "accent" | "hit" | "miss" | "beam" | "prior";

interface SliderProps extends Range {
  readonly label: string;
  readonly value: number;
  /** The value that a double-click restores; other values are marked as changed. */
  readonly initial: number;
  readonly unit?: string;
  /** One sentence on what it does. */
  readonly sentence: string;
  readonly tone?: Tone;
  readonly disabled?: boolean;
  readonly onInput: (value: number) => void;
}

const POSITIONS = 1000;

/**
 * A native range input with a number field beside it. While it is dragged it shows the dragged value and not the one
 * from the server, so that it does not jump under the pointer.
 */
export function Slider(props: SliderProps) {
  const { label, initial, unit = "", sentence, tone = "accent", disabled = false, onInput } = props;
  const id = useId();
  const held = useSignal<number | null>(null);
  const before = useRef(0); // the value at the start of the drag
  const value = held.value ?? props.value;
  const places = shownDecimals(props.step);
  const fraction = toFraction(value, props);
  const text = `${written(value, places)}${unit ? ` ${unit}` : ""}`;

  const change = (next: number): void => {
    if (next !== value) onInput(next);
  };

  return (
    <div class={`field slider tone-${tone}${value === initial ? "" : " changed"}`}>
      <span class="field-label">
        <label for={`${id}-range`}>{label}</label>
        <Tooltip id={`${id}-description`} text={sentence} about={label} />
      </span>
      <span class="slider-value">
        <NumberField
          label={`${label}, as a number`}
          value={value}
          low={props.low}
          high={props.high}
          step={props.step}
          disabled={disabled}
          onChange={change}
        />
        <span class="slider-unit">{unit || null}</span>
      </span>
      <input
        id={`${id}-range`}
        class="slider-range"
        type="range"
        min={0}
        max={POSITIONS}
        step={1}
        value={Math.round(fraction * POSITIONS)}
        disabled={disabled}
        aria-valuetext={text}
        aria-describedby={`${id}-description`}
        title={`${text} (double-click: reset to ${written(initial, places)})`}
        style={{ "--filled": `${fraction * 100}%` }}
        onPointerDown={() => {
          before.current = value;
          held.value = value;
        }}
        onPointerUp={() => {
          held.value = null;
        }}
        onPointerCancel={() => {
          // The touch became a scroll of the page: restore the value.
          change(before.current);
          held.value = null;
        }}
        onInput={(event) => {
          const next = fromFraction(event.currentTarget.valueAsNumber / POSITIONS, props);
          if (held.value !== null) held.value = next;
          change(next);
        }}
        onKeyDown={(event) => {
          const next = keyed(event.key, event.shiftKey, value, props);
          if (next === null) return;
          event.preventDefault();
          change(next);
        }}
        onDblClick={() => {
          held.value = null;
          change(snap(initial, props));
        }}
      />
    </div>
  );
}
