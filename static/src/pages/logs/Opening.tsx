import { Button } from "../../ui/Button";
import { progressText } from "../../ui/Working";
import { opening } from "./library";

/** Shown in place of a log's view until it has loaded: what the server does for it, how far it is, and since when. */
export function Opening({ onCancel }: { readonly onCancel?: () => void }) {
  const now = opening.value;
  const fraction = now?.fraction ?? null;
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
      <div class={fraction === null ? "progress waiting wide" : "progress wide"} aria-hidden="true">
        <span style={fraction === null ? undefined : { transform: `scaleX(${fraction})` }} />
      </div>
      {now && onCancel && <Button onClick={onCancel}>Cancel</Button>}
    </div>
  );
}
