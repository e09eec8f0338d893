/** A tabbed region beside a map: one of several groups of controls is open at a time, in the place of the last one. */

import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import "./dock.css";

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

function Tabs({ class: className, label, tabs, open, onOpen }: TabsProps) {
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

interface Grouped {
  readonly id: string;
  readonly title: string;
  readonly section?: string;
  readonly purpose?: string;
  readonly badge?: string | null;
}

interface Section<G extends Grouped> {
  /** The id of its first group. */
  readonly id: string;
  readonly title: string;
  /** The titles of its groups; of a single group what it is for. */
  readonly hint: string | null;
  /** The badge of its first group that has one. */
  readonly badge: string | null;
  readonly groups: readonly G[];
}

/** The groups by sections, in their order. */
export function sectionsOf<G extends Grouped>(groups: readonly G[]): readonly Section<G>[] {
  const runs: G[][] = [];
  for (const group of groups) {
    const last = runs.at(-1);
    if (last && group.section !== undefined && last[0]?.section === group.section) last.push(group);
    else runs.push([group]);
  }
  return runs.map((run) => {
    const first = run[0] as G;
    const isSingle = run.length === 1;
    return {
      id: first.id,
      title: isSingle ? first.title : (first.section ?? first.title),
      hint: isSingle ? (first.purpose ?? null) : run.map(({ title }) => title).join(", "),
      badge: run.find(({ badge }) => badge)?.badge ?? null,
      groups: run,
    };
  });
}

export interface DockGroup {
  readonly id: string;
  /** The text of its tab. */
  readonly title: string;
  /** The section that it is in, with the groups beside it that name the same; without one it is a section of its own. */
  readonly section?: string;
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

export function Dock({ label, groups, open, isInert = false }: DockProps) {
  const id = useId();
  const keptGroups = useRef(new Set<string>());
  const lastOf = useRef(new Map<string, string>());
  const sections = sectionsOf(groups);
  const current = groups.find((group) => group.id === open.value) ?? groups[0];
  const section = sections.find(({ groups: own }) => own.some((group) => group === current));
  if (!current || !section) return <div class="dock" />;
  if (current.keeps) keptGroups.current.add(current.id);
  lastOf.current.set(section.id, current.id);
  const hasTabs = section.groups.length > 1;
  const tabOf = (group: string): string => `${id}-tab-${group}`;
  return (
    <div class="dock" inert={isInert}>
      <Tabs
        class="dock-tabs"
        label={label}
        tabs={sections.map((tab) => ({
          key: tab.id,
          id: `${id}-section-${tab.id}`,
          controls: tab === section && hasTabs ? `${id}-of-${tab.id}` : `${id}-${tab.groups[0]?.id}`,
          title: tab.title,
          hint: tab.hint,
          badge: tab.badge,
        }))}
        open={section.id}
        onOpen={(key) => {
          const chosen = sections.find((section) => section.id === key);
          const last = lastOf.current.get(key);
          // A section opens at the group of it that was open last.
          const group = chosen?.groups.find((group) => group.id === last) ?? chosen?.groups[0];
          if (group) open.value = group.id;
        }}
      />
      <div
        class="dock-section"
        id={`${id}-of-${section.id}`}
        {...(hasTabs ? { role: "tabpanel", "aria-labelledby": `${id}-section-${section.id}` } : {})}
      >
        {hasTabs && (
          <Tabs
            key={section.id}
            class="dock-subtabs"
            label={section.title}
            tabs={section.groups.map((group) => ({
              key: group.id,
              id: tabOf(group.id),
              controls: `${id}-${group.id}`,
              title: group.title,
              hint: group.purpose ?? null,
              badge: group.badge ?? null,
            }))}
            open={current.id}
            onOpen={(key) => {
              open.value = key;
            }}
          />
        )}
        {groups.map((group) => (
          <div
            key={group.id}
            class="dock-group"
            role="tabpanel"
            id={`${id}-${group.id}`}
            aria-labelledby={hasTabs ? tabOf(group.id) : `${id}-section-${section.id}`}
            // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
            tabIndex={0}
            data-group={group.id}
            hidden={group !== current}
          >
            {group.purpose && group === current && <p class="dock-purpose">{group.purpose}</p>}
            {(group === current || keptGroups.current.has(group.id)) && group.content()}
          </div>
        ))}
      </div>
    </div>
  );
}
