import type { ComponentChildren } from "preact";
import "./plate.css";

interface PlateProps {
  readonly title: string;
  readonly note?: string;
  readonly actions?: ComponentChildren;
  readonly caption?: ComponentChildren;
  readonly children: ComponentChildren;
}

/** A picture with a title above it and a caption below it. */
export function Plate({ title, note, actions, caption, children }: PlateProps) {
  return (
    <section class="plate" aria-label={title}>
      <header class="plate-head">
        <h2>{title}</h2>
        {note && <span class="plate-note">{note}</span>}
        {actions && <div class="plate-actions">{actions}</div>}
      </header>
      <div class="plate-picture">{children}</div>
      {caption !== undefined && <div class="plate-caption">{caption}</div>}
    </section>
  );
}
