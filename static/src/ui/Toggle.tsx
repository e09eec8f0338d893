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
