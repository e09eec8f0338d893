/** A stage with one to four views; the borders between them are dragged. On a phone each is a page to swipe to. */

import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import { useMedia } from "../browser/media";
import { Select } from "../Select";
import { Splitter } from "../split/Splitter";
import { type Layout, LIMITS, withView } from "./layout";
import "./stage.css";

export interface StageView {
  readonly kind: string;
  readonly title: string;
  /** Whether its content shows the menu of views, which the stage shows above it otherwise. */
  readonly hasOwnHead?: boolean;
  /** Called with the menu of views; with null where there is none: of one view, or of views that stay together. */
  readonly content: (head: ComponentChildren) => ComponentChildren;
}

interface StageProps {
  /** All views that there are; those of the layout are shown. */
  readonly views: readonly StageView[];
  readonly layout: Layout;
  readonly onLayout: (layout: Layout) => void;
  /** Whether the views of this layout are seen at once on a phone too, as the page's own style arranges them. */
  readonly isTogether?: boolean;
}

/** Bring the view of a kind in sight, once it is in the layout: on a phone it may be beside the others. */
export function showView(kind: string): void {
  requestAnimationFrame(() => {
    document.querySelector(`.view-pane[data-view="${kind}"]`)?.scrollIntoView({ inline: "start", block: "nearest" });
  });
}

const PHONE = "(max-width: 44rem), (max-height: 36rem)";

export function Stage({ views, layout, onLayout, isTogether = false }: StageProps) {
  const id = useId();
  const stage = useRef<HTMLDivElement>(null);
  const isPhone = useMedia(PHONE).value;
  const { arrangement } = layout;
  const shown = layout.views.flatMap((kind) => views.find((view) => view.kind === kind) ?? []);
  const hasHeads = shown.length > 1 && !(isPhone && isTogether);
  const head = (kind: string, place: number): ComponentChildren =>
    hasHeads ? (
      <>
        <Select
          class="view-choice"
          label={`View ${place + 1}`}
          value={kind}
          options={views.map((view) => ({ value: view.kind, label: view.title }))}
          onChange={(chosen) => onLayout(withView(layout, place, chosen))}
        />
        {isPhone && <Pages count={shown.length} place={place} stage={stage} />}
      </>
    ) : null;
  useEffect(() => {
    const onKey = (event: KeyboardEvent): void => {
      if (event.key !== "F6" || event.ctrlKey || event.metaKey || event.altKey) return;
      const panes = [...(stage.current?.querySelectorAll<HTMLElement>(":scope > .view-pane") ?? [])];
      if (panes.length < 2) return;
      event.preventDefault();
      const now = panes.findIndex((pane) => pane.contains(document.activeElement));
      panes[(now + (event.shiftKey ? panes.length - 1 : 1)) % panes.length]?.focus();
    };
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, []);
  const splitter = (axis: "x" | "y") => (
    <Splitter
      key={axis}
      label={axis === "x" ? "Border between the columns of views" : "Border between the rows of views"}
      controls={`${id}-0`}
      axis={axis}
      share={layout[axis]}
      limits={LIMITS}
      onShare={(share) => onLayout({ ...layout, [axis]: share })}
      onReset={() => onLayout({ ...layout, [axis]: 0.5 })}
    />
  );
  return (
    <div
      class={`view-stage view-stage-${arrangement} ${isPhone && isTogether ? "view-stage-together" : ""}`.trim()}
      ref={stage}
      data-split=""
      style={{ "--share-x": layout.x, "--share-y": layout.y }}
    >
      {shown.map((view, place) => (
        <section
          key={view.kind}
          class="view-pane"
          id={`${id}-${place}`}
          aria-label={view.title}
          data-view={view.kind}
          data-place={place}
          tabIndex={-1}
        >
          {hasHeads && !view.hasOwnHead && <header class="view-head">{head(view.kind, place)}</header>}
          <div class="view-content">{view.content(head(view.kind, place))}</div>
        </section>
      ))}
      {!isPhone && (arrangement === "beside" || arrangement === "four") && splitter("x")}
      {!isPhone && (arrangement === "above" || arrangement === "four") && splitter("y")}
    </div>
  );
}

interface PagesProps {
  readonly count: number;
  readonly place: number;
  readonly stage: { readonly current: HTMLElement | null };
}

/** On a phone: a button for each view, beside swiping, which pans where a view is a map. */
function Pages({ count, place, stage }: PagesProps) {
  const go = (to: number): void =>
    stage.current
      ?.querySelector<HTMLElement>(`:scope > [data-place="${to}"]`)
      ?.scrollIntoView({ inline: "start", block: "nearest" });
  return (
    <div class="view-pages" role="toolbar" aria-label="Views">
      {Array.from({ length: count }, (_, n) => (
        <button
          key={n}
          type="button"
          aria-label={`Go to view ${n + 1}`}
          aria-current={n === place ? "true" : undefined}
          onClick={() => go(n)}
        >
          {n + 1}
        </button>
      ))}
    </div>
  );
}
