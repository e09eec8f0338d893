import { Button } from "../../ui/Button";
import { ProgressBar } from "../../ui/ProgressBar";
import { progressText } from "../../ui/Working";
import { opening } from "./library/library";

/** Shown in place of a log's view until it has loaded: what the server does for it, how far it is, and since when. */
export function Opening({ onCancel }: { readonly onCancel?: () => void }) {
  const now = opening.value;
  return (
    <div class="viewer-message" role="status">
      <p class="prose">
        {now?.what ?? "Opening the log"} …{" "}
        {/* Hidden from screen readers, which would announce it four times a second. */}
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
