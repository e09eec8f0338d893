import type { ComponentChildren } from "preact";
import { Button } from "../../ui/Button";
import { ProgressBar } from "../../ui/ProgressBar";
import { progressText } from "../../ui/Working";
import type { MakingAnswer } from "../../wire/http";

interface OpeningProps {
  /** What the server does for it, how far it is, and since when; null before it has said so. */
  readonly now: MakingAnswer | null;
  /** What is said until then. */
  readonly what: string;
  readonly onCancel?: (() => void) | undefined;
  /** What is being opened. */
  readonly children?: ComponentChildren;
}

/** Shown in place of a view until it has loaded. */
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
