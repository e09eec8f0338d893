import "./switchChip.css";

interface SwitchChipProps {
  readonly label: string;
  readonly checked: boolean;
  /** What is switched on is a fault, and has the colour of one. */
  readonly isFault?: boolean;
  readonly title?: string;
  readonly onChange: (checked: boolean) => void;
}

/** A switch as small as its label, for rows of several. */
export function SwitchChip({ label, checked, isFault = false, title, onChange }: SwitchChipProps) {
  return (
    <button
      type="button"
      role="switch"
      class={isFault ? "switch-chip fault" : "switch-chip"}
      aria-checked={checked}
      title={title}
      onClick={() => onChange(!checked)}
    >
      {label}
    </button>
  );
}
