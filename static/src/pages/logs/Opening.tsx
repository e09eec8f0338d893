import type { ComponentChildren } from "preact";
import { Button } from "../../ui/Button";
import { ProgressBar } from "../../ui/ProgressBar";
import { progressText } from "../../ui/Working";
import type { MakingAnswer } from "../../wire/http";

interface OpeningProps {
  /** The server's work, its progress and its start time; null before the server has reported it. */
  readonly now: MakingAnswer | null;
  /** Shown until then. */
  readonly what: string;
  readonly onCancel?: (() => void) | undefined;
  /** What is being opened. */
  readonly children?: ComponentChildren;
}

/** Shown instead of a view until it has loaded. */
export function Opening({ now, what, onCancel, children }: OpeningProps) {
  return (
    <div class="viewer-message" role="status">
      {children}
      <p class="prose">
        {now?.what ?? what} … {/* Hidden from screen readers, which would announce it four times a second. */}
        {now && (
          <span class="number" aria-hidden="true">
            {progressText(now)}
          </span>
        )}
      </p>
      <ProgressBar fraction={now?.fraction ?? null} isWide />
      {now && onCancel && <Button onClick={onCancel}>Cancel</Button>}
    </div>
  );
}
