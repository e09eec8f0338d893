/** A list of tabs: one is in the order of the page, the arrow keys open the others. */

import { useEffect, useRef } from "preact/hooks";

interface Tab {
  readonly key: string;
  /** Of the element. */
  readonly id: string;
  /** The id of the panel that it opens. */
  readonly controls: string;
  readonly title: string;
  readonly hint: string | null;
  readonly badge: string | null;
}

interface TabsProps {
  readonly class: string;
  /** Accessible name of the list. */
  readonly label: string;
  readonly tabs: readonly Tab[];
  /** The key of the open one. */
  readonly open: string;
  readonly onOpen: (key: string) => void;
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

export function Tabs({ class: className, label, tabs, open, onOpen }: TabsProps) {
  const list = useRef<HTMLDivElement>(null);
  const at = tabs.findIndex(({ key }) => key === open);
  useEffect(() => {
    // Where the tabs scroll in one line, the open one is in sight.
    const now = list.current;
    const tab = now?.querySelector<HTMLElement>("[aria-selected=true]");
    if (!now || !tab || now.scrollWidth <= now.clientWidth) return;
    now.scrollLeft = tab.offsetLeft - (now.clientWidth - tab.offsetWidth) / 2;
  }, [open]);
  const onKey = (event: KeyboardEvent): void => {
    const next = keyedTab(event.key, at, tabs.length);
    const tab = next === null ? undefined : tabs[next];
    if (next === null || !tab) return;
    event.preventDefault();
    onOpen(tab.key);
    list.current?.querySelectorAll<HTMLElement>("[role=tab]")[next]?.focus();
  };
  return (
    <div class={className} role="tablist" aria-label={label} ref={list} onKeyDown={onKey}>
      {tabs.map((tab, n) => (
        <button
          key={tab.key}
          type="button"
          class="dock-tab"
          role="tab"
          id={tab.id}
          aria-controls={tab.controls}
          aria-selected={n === at}
          tabIndex={n === at ? 0 : -1}
          {...(tab.hint ? { title: tab.hint } : {})}
          onClick={() => onOpen(tab.key)}
        >
          {tab.title}
          {tab.badge === "on" ? (
            <span class="dock-badge dock-dot">
              <span class="visually-hidden">on</span>
            </span>
          ) : (
            tab.badge && <span class="dock-badge">{tab.badge}</span>
          )}
        </button>
      ))}
    </div>
  );
}
