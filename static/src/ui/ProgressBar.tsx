interface ProgressBarProps {
  /** 0 to 1; null where it is not known. */
  readonly fraction: number | null;
  readonly isWide?: boolean;
}

/** How far a computation is; hidden from screen readers, which have it as text. */
export function ProgressBar({ fraction, isWide = false }: ProgressBarProps) {
  const isKnown = fraction !== null;
  return (
    <div class={`progress${isKnown ? "" : " waiting"}${isWide ? " wide" : ""}`} aria-hidden="true">
      <span {...(isKnown ? { style: { transform: `scaleX(${fraction})` } } : {})} />
    </div>
  );
}
