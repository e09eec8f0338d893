import { signal } from "@preact/signals";
import { Button } from "./Button";
import { hasStalled } from "./browser/awaited";

interface ToastData {
  readonly id: number;
  readonly text: string;
  readonly kind: "note" | "error";
}

/** The message that is shown, if one is: a new one replaces it. */
const shown = signal<ToastData | null>(null);
let next = 1;

const drop = (id: number): void => {
  if (shown.value?.id === id) shown.value = null;
};

/** Show a short message in a live region, in place of the one before. A message that is already shown is not repeated. */
export function toast(text: string, kind: "note" | "error" = "note"): void {
  if (shown.value?.text === text) return;
  const id = next++;
  shown.value = { id, text, kind };
  setTimeout(() => drop(id), kind === "error" ? 9000 : 5000);
}

interface ToastsProps {
  /** What goes on without the server, in a sentence. */
  readonly meanwhile?: string;
}

/** The container of the message: once on each page. Below it stands that the server does not answer, while that is so. */
export function Toasts({ meanwhile = "What is shown stays; the page continues as soon as it answers." }: ToastsProps) {
  const now = shown.value;
  return (
    <div class="toasts" role="status" aria-live="polite">
      {now && (
        <div class={`toast ${now.kind}`} key={now.id}>
          <span>{now.text}</span>
          <Button icon="close" label="Dismiss" onClick={() => drop(now.id)} />
        </div>
      )}
      {hasStalled.value && <p class="no-answer">The server does not answer. {meanwhile}</p>}
    </div>
  );
}
