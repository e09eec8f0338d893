import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";

interface PanelProps {
  readonly title: string;
  /** A short note beside the title. */
  readonly note?: ComponentChildren;
  readonly open?: boolean;
  readonly children: ComponentChildren;
}

/** A titled box that folds. Its content is rendered when it is first unfolded. */
export function Disclosure({ title, note, open = false, children }: PanelProps) {
  const seen = useSignal(open);
  return (
    <details
      class="panel"
      open={open}
      onToggle={(event) => {
        if (event.currentTarget.open) seen.value = true;
      }}
    >
      <summary>
        {title} <span class="panel-note">{note}</span>
      </summary>
      <div class="panel-body">{seen.value && children}</div>
    </details>
  );
}

/** A titled box. */
export function Panel({ title, note, children }: Omit<PanelProps, "open">) {
  return (
    <section class="panel" aria-label={title}>
      <h2 class="panel-title">
        {title} <span class="panel-note">{note}</span>
      </h2>
      <div class="panel-body">{children}</div>
    </section>
  );
}
