import type { Signal } from "@preact/signals";
import { useId } from "preact/hooks";
import { Tooltip } from "./Tooltip";

interface ToggleProps {
  readonly label: string;
  readonly checked: boolean;
  readonly sentence?: string;
  readonly disabled?: boolean;
  readonly onChange: (checked: boolean) => void;
}

/** A switch with immediate effect. */
export function Toggle({ label, checked, sentence, disabled = false, onChange }: ToggleProps) {
  const id = useId();
  return (
    <div class="field">
      <span class="field-label">
        <span>{label}</span>
        {sentence && <Tooltip id={id} text={sentence} about={label} />}
      </span>
      <span class="toggle">
        <input
          type="checkbox"
          role="switch"
          aria-checked={checked}
          aria-label={label}
          {...(sentence ? { "aria-describedby": id } : {})}
          checked={checked}
          disabled={disabled}
          onChange={(event) => onChange(event.currentTarget.checked)}
        />
        <span class="toggle-track" />
      </span>
    </div>
  );
}

type ToggleOfProps = Omit<ToggleProps, "checked" | "onChange"> & { readonly signal: Signal<boolean> };

/** A switch that shows and sets a signal. */
export function ToggleOf({ signal, ...rest }: ToggleOfProps) {
  return (
    <Toggle
      {...rest}
      checked={signal.value}
      onChange={(checked) => {
        signal.value = checked;
      }}
    />
  );
}
