import { signal } from "@preact/signals";
import { Button } from "./Button";

interface ToastData {
  readonly id: number;
  readonly text: string;
  readonly kind: "note" | "error";
}

const shown = signal<readonly ToastData[]>([]);
let next = 1;

const drop = (id: number): void => {
  shown.value = shown.value.filter((one) => one.id !== id);
};

/** Show a short message in a live region. A message that is already shown is not repeated. */
export function toast(text: string, kind: "note" | "error" = "note"): void {
  if (shown.value.some((one) => one.text === text)) return;
  const id = next++;
  shown.value = [...shown.value.slice(-2), { id, text, kind }];
  setTimeout(() => drop(id), kind === "error" ? 9000 : 5000);
}

/** The container of the toasts: once on each page. */
export function Toasts() {
  return (
    <div class="toasts" role="status" aria-live="polite">
      {shown.value.map((one) => (
        <div class={`toast ${one.kind}`} key={one.id}>
          <span>{one.text}</span>
          <Button icon="close" label="Dismiss" onClick={() => drop(one.id)} />
        </div>
      ))}
    </div>
  );
}
