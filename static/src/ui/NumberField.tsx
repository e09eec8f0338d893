import { useSignal } from "@preact/signals";
import { keyed, numberOf, type Range, shownDecimals, written } from "./numbers";

interface NumberFieldProps extends Partial<Range> {
  /** NaN for none: the field is empty. */
  readonly value: number;
  /** Its accessible name, where no label element gives it one. */
  readonly label?: string;
  readonly id?: string;
  readonly class?: string;
  readonly disabled?: boolean;
  /** Called at each key with what is typed so far; NaN where that is no number. */
  readonly onType?: (value: number) => void;
  /** Called with a number within the range once it is complete. */
  readonly onChange: (value: number) => void;
}

/**
 * A number as text: with a minus sign or a hyphen, a point or a comma. The arrow keys change it by a step. While one
 * types, the text is kept as it is when the page is drawn again.
 */
export function NumberField(props: NumberFieldProps) {
  const { value, low = -Infinity, high = Infinity, step = 0, label, id, disabled = false, onType, onChange } = props;
  const typed = useSignal<string | null>(null);
  const shown = typed.value === null ? value : numberOf(typed.value);
  const bound = (name: string, limit: number) => (Number.isFinite(limit) ? { [name]: limit } : {});
  const change = (wanted: number): void => {
    typed.value = null;
    if (Number.isFinite(wanted)) onChange(Math.min(high, Math.max(low, wanted)));
  };
  return (
    <input
      role="spinbutton"
      {...(id === undefined ? {} : { id })}
      {...(props.class === undefined ? {} : { class: props.class })}
      {...(label === undefined ? {} : { "aria-label": label })}
      inputMode={low < 0 ? "text" : "decimal"} // a telephone's decimal keys may have no minus sign
      autoComplete="off"
      {...bound("aria-valuenow", value)}
      {...bound("aria-valuemin", low)}
      {...bound("aria-valuemax", high)}
      aria-invalid={!Number.isNaN(value) && !(low <= shown && shown <= high)}
      value={typed.value ?? (Number.isNaN(value) ? "" : written(value, shownDecimals(step)))}
      disabled={disabled}
      onInput={(event) => {
        typed.value = event.currentTarget.value;
        onType?.(numberOf(event.currentTarget.value));
      }}
      onChange={(event) => change(numberOf(event.currentTarget.value))}
      onKeyDown={(event) => {
        if (!/^Arrow(Up|Down)$/.test(event.key)) return; // the others move the caret
        event.preventDefault();
        change(keyed(event.key, event.shiftKey, value || 0, { low, high, step }) ?? value);
      }}
    />
  );
}
