/** A tabbed region beside a map: one of several groups of controls is open at a time, in the place of the last one. */

import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import "./dock.css";

export interface DockGroup {
  readonly id: string;
  /** The text of its tab. */
  readonly title: string;
  /** What the group is for: shown at its top and with its tab. */
  readonly purpose?: string;
  /** A short text beside the title, e.g. a number of findings. */
  readonly badge?: string | null;
  /** Whether the group, once opened, stays in the page while another one is open, with its folds and its scroll. */
  readonly keeps?: boolean;
  readonly content: () => ComponentChildren;
}

interface DockProps {
  /** Accessible name of the list of tabs. */
  readonly label: string;
  readonly groups: readonly DockGroup[];
  /** The id of the open group; of an id that no group has, the first group is open. */
  readonly open: Signal<string>;
  /** Whether nothing in it can be used. */
  readonly isInert?: boolean;
}

const STEPS: Readonly<Record<string, (now: number, count: number) => number>> = {
  ArrowRight: (now, count) => (now + 1) % count,
  ArrowDown: (now, count) => (now + 1) % count,
  ArrowLeft: (now, count) => (now + count - 1) % count,
  ArrowUp: (now, count) => (now + count - 1) % count,
  Home: () => 0,
  End: (_, count) => count - 1,
};

/** The index of the tab that a key leads to, null for other keys. */
export function keyedTab(key: string, now: number, count: number): number | null {
  return STEPS[key]?.(now, count) ?? null;
}

export function Dock({ label, groups, open, isInert = false }: DockProps) {
  const id = useId();
  const tabs = useRef<HTMLDivElement>(null);
  const kept = useRef(new Set<string>());
  const at = Math.max(
    0,
    groups.findIndex((group) => group.id === open.value),
  );
  const current = groups[at];
  if (current?.keeps) kept.current.add(current.id);
  useEffect(() => {
    // Where the tabs scroll in one line, the open one is in sight.
    const list = tabs.current;
    const tab = list?.querySelector<HTMLElement>("[aria-selected=true]");
    if (!list || !tab || list.scrollWidth <= list.clientWidth) return;
    list.scrollLeft = tab.offsetLeft - (list.clientWidth - tab.offsetWidth) / 2;
  }, [current?.id]);
  const onKey = (event: KeyboardEvent): void => {
    const next = keyedTab(event.key, at, groups.length);
    const group = next === null ? undefined : groups[next];
    if (next === null || !group) return;
    event.preventDefault();
    open.value = group.id;
    tabs.current?.querySelectorAll<HTMLElement>("[role=tab]")[next]?.focus();
  };
  return (
    <div class="dock" inert={isInert}>
      <div class="dock-tabs" role="tablist" aria-label={label} ref={tabs} onKeyDown={onKey}>
        {groups.map((group, n) => (
          <button
            key={group.id}
            type="button"
            class="dock-tab"
            role="tab"
            id={`${id}-tab-${group.id}`}
            aria-controls={`${id}-${group.id}`}
            aria-selected={n === at}
            tabIndex={n === at ? 0 : -1}
            {...(group.purpose ? { title: group.purpose } : {})}
            data-group={group.id}
            onClick={() => {
              open.value = group.id;
            }}
          >
            {group.title}
            {group.badge && <span class="dock-badge">{group.badge}</span>}
          </button>
        ))}
      </div>
      {groups.map((group, n) => (
        <div
          key={group.id}
          class="dock-group"
          role="tabpanel"
          id={`${id}-${group.id}`}
          aria-labelledby={`${id}-tab-${group.id}`}
          // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
          tabIndex={0}
          data-group={group.id}
          hidden={n !== at}
        >
          {group.purpose && n === at && <p class="dock-purpose">{group.purpose}</p>}
          {(n === at || kept.current.has(group.id)) && group.content()}
        </div>
      ))}
    </div>
  );
}
