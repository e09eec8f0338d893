import type { ComponentChildren } from "preact";
import "./picture.css";

interface PlateProps {
  readonly title: string;
  readonly note?: string;
  /** For a picture in a view with a name: the menu of views, instead of the title; null for none. */
  readonly head?: ComponentChildren;
  readonly actions?: ComponentChildren;
  readonly caption?: ComponentChildren;
  readonly children: ComponentChildren;
}

/** A picture with a title above it and a caption below it. */
export function Plate({ title, note, head, actions, caption, children }: PlateProps) {
  return (
    <section class="plate" aria-label={head === undefined ? title : undefined}>
      <header class="plate-head">
        <h2 class={head ? "visually-hidden" : ""}>{title}</h2>
        {head}
        {note && <span class="plate-note">{note}</span>}
        {actions && <div class="plate-actions">{actions}</div>}
      </header>
      <div class="plate-picture">{children}</div>
      {caption !== undefined && <div class="plate-caption">{caption}</div>}
    </section>
  );
}
