interface ProgressBarProps {
  /** 0 to 1; null where it is not known. */
  readonly fraction: number | null;
  /** What is under way, where no text beside the bar tells screen readers of it. */
  readonly label?: string;
  readonly isWide?: boolean;
}

/** How far a computation is. Without a label it is hidden from screen readers, which then have it as text. */
export function ProgressBar({ fraction, label, isWide = false }: ProgressBarProps) {
  const isKnown = fraction !== null;
  return (
    <div
      class={`progress${isKnown ? "" : " waiting"}${isWide ? " wide" : ""}`}
      {...(label === undefined
        ? { "aria-hidden": "true" as const }
        : { role: "progressbar" as const, "aria-label": label })}
      {...(label !== undefined && isKnown ? { "aria-valuenow": Math.floor(100 * fraction) } : {})}
    >
      <span {...(isKnown ? { style: { transform: `scaleX(${fraction})` } } : {})} />
    </div>
  );
}
