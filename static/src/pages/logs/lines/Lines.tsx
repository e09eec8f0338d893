/** Log lines of nodes by level, node and text. A click on a line goes to its time. */

import { useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useId, useMemo, useRef } from "preact/hooks";
import { clockTime, shownTime } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { selected } from "../../../ui/bound";
import { plural } from "../../../ui/numbers";
import { Select } from "../../../ui/Select";
import { WhenKnown } from "../contents/useContents";
import { scansAt } from "../time/scanTimes";
import { LEVELS, type Line, type LinesState, levelName, matching, newestAt, nodesOf, WARNING } from "./lines";
import "./lines.css";

/** Lines drawn before and after the present one; a button adds the same number. */
const AROUND = 150;

interface LinesProps {
  readonly store: Store;
  readonly lines: LinesState;
}

export function Lines({ store, lines }: LinesProps) {
  return <WhenKnown>{() => <Loaded store={store} lines={lines} />}</WhenKnown>;
}

function Loaded({ store, lines: state }: LinesProps) {
  const all = state.lines.value;
  const [least, node, text] = [state.least.value, state.node.value, state.text.value];
  const isThere = useRef(false); // whether the log has reached the selected line
  const matches = useMemo(() => matching(all ?? [], least, node, text), [all, least, node, text]);
  useSignalEffect(() => {
    // A selected line is the present one until the log moves to another time.
    const [frame, chosen] = [store.frame.value, state.chosen.value];
    if (!frame || !chosen) return;
    if (frame.index === chosen.scans) isThere.current = true;
    else if (isThere.current) state.chosen.value = null;
  });
  if (state.failure.value !== null) return <p role="alert">{state.failure.value}</p>;
  if (all === null) return <p class="quiet">…</p>;
  if (all.length === 0) {
    return <p class="quiet">No node logged anything: the recording has no lines on /rosout, and no /diagnostics.</p>;
  }
  const now = store.frame.value?.stamp ?? 0;
  const chosen = state.chosen.value;
  const gone = chosen ? matches.indexOf(chosen.line) : -1;
  const present = gone >= 0 ? gone : newestAt(matches, now);
  const go = (place: number): void => {
    const [line, way] = [matches[place], store.trajectory.peek()];
    if (!line || !way) return;
    const scans = scansAt(way, line.seconds, store.frame.peek()?.count ?? 0);
    isThere.current = false;
    state.chosen.value = { line, scans };
    store.goTo(scans);
  };
  return (
    <div class="lines">
      <Search state={state} all={all} onStep={(by) => go(present + by)}>
        <output class="quiet number">
          {matches.length === all.length
            ? plural(all.length, "line")
            : `${matches.length.toLocaleString("en")} of ${all.length.toLocaleString("en")}`}
        </output>
      </Search>
      <List store={store} found={matches} present={present} onGo={go} />
      {state.leftOut.value > 0 && (
        <p class="quiet">
          {state.leftOut.value.toLocaleString("en")} more lines are left out: of each kind, from warnings on and below
          them, the first 10,000 are listed.
        </p>
      )}
    </div>
  );
}

interface SearchProps {
  readonly state: LinesState;
  readonly all: readonly Line[];
  /** Go to the next or the previous match. */
  readonly onStep: (by: 1 | -1) => void;
  readonly children: ComponentChildren;
}

function Search({ state, all, onStep, children }: SearchProps) {
  const nodes = useMemo(() => nodesOf(all), [all]);
  const count = useMemo(() => all.filter(({ level }) => level >= WARNING).length, [all]);
  return (
    <search class="lines-search">
      <Select
        label="Level"
        value={String(state.least.value)}
        options={[
          { value: "0", label: "All levels" },
          ...LEVELS.filter(([level]) => level > 10).map(([level, name]) => ({
            value: String(level),
            label:
              (level === 50 ? "fatal only" : `${name} and above`) +
              (level === WARNING ? ` (${count.toLocaleString("en")})` : ""),
          })),
        ]}
        onChange={(level) => {
          state.least.value = Number(level);
        }}
      />
      {nodes.length > 1 && (
        <Select label="Node" {...selected(state.node)} options={[{ value: "", label: "All nodes" }, ...nodes]} />
      )}
      <input
        class="field-text"
        type="search"
        aria-label="Search in the lines"
        aria-keyshortcuts="Enter Shift+Enter"
        placeholder="Search"
        value={state.text.value}
        onInput={(event) => {
          state.text.value = event.currentTarget.value;
        }}
        onKeyDown={(event) => {
          if (event.key !== "Enter") return;
          event.preventDefault();
          onStep(event.shiftKey ? -1 : 1);
        }}
      />
      <Button kind="quiet" icon="up" label="Previous line (Shift+Enter)" onClick={() => onStep(-1)} />
      <Button kind="quiet" icon="unfold" label="Next line (Enter)" onClick={() => onStep(1)} />
      {children}
    </search>
  );
}

interface ListProps {
  readonly store: Store;
  readonly found: readonly Line[];
  /** The index of the line at the present time; −1 before the first. */
  readonly present: number;
  readonly onGo: (place: number) => void;
}

/** Keys of the list, and the number of lines that each moves. */
const KEYS: Readonly<Record<string, number>> = {
  ArrowDown: 1,
  ArrowUp: -1,
  PageDown: 10,
  PageUp: -10,
  Home: Number.NEGATIVE_INFINITY,
  End: Number.POSITIVE_INFINITY,
};

function List({ store, found, present, onGo }: ListProps) {
  const id = useId();
  const list = useRef<HTMLDivElement>(null);
  const more = useSignal<readonly [before: number, after: number]>([0, 0]);
  useEffect(() => {
    more.value = [0, 0];
  }, [found]);
  const begin = Math.max(0, Math.min(present - AROUND, found.length - 2 * AROUND) - more.value[0]);
  const end = Math.min(found.length, Math.max(present + AROUND, 2 * AROUND) + more.value[1]);
  useEffect(() => {
    const line = list.current?.querySelector('[aria-selected="true"]');
    if (line) scrollWithin(line);
  }, [present, found]);
  const onKey = (event: KeyboardEvent): void => {
    const by = KEYS[event.key];
    if (by === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    onGo(Math.min(found.length - 1, Math.max(0, present + by)));
  };
  if (found.length === 0) return <p class="quiet">No line matches.</p>;
  return (
    <>
      {begin > 0 && (
        <Button kind="quiet" onClick={() => (more.value = [more.peek()[0] + 2 * AROUND, more.peek()[1]])}>
          Show earlier lines
        </Button>
      )}
      <div
        ref={list}
        class="lines-list"
        role="listbox"
        aria-label="Log lines"
        tabIndex={0}
        aria-activedescendant={present >= 0 ? `${id}-${present}` : undefined}
        onKeyDown={onKey}
      >
        {found.slice(begin, end).map((line, n) => (
          // biome-ignore lint/a11y/useKeyWithClickEvents: the list has the focus and the keys
          <div
            key={begin + n}
            id={`${id}-${begin + n}`}
            class={`log-line line-${levelName(line.level)}`}
            role="option"
            tabIndex={-1}
            aria-selected={begin + n === present}
            title={`Go to ${shownTime(store, line.seconds)}`}
            onClick={() => onGo(begin + n)}
          >
            <span class="number">{clockTime(store, line.seconds)}</span>
            <span class="line-level">{levelName(line.level)}</span>
            <span class="line-text">
              <span class="line-name">{line.name}</span> {line.text}
            </span>
          </div>
        ))}
      </div>
      {end < found.length && (
        <Button kind="quiet" onClick={() => (more.value = [more.peek()[0], more.peek()[1] + 2 * AROUND])}>
          Show later lines
        </Button>
      )}
    </>
  );
}

/**
 * Scroll the scrolling container of an element vertically until the element is in view. `scrollIntoView` would also
 * scroll outer containers: on a phone the stage, whose views are side by side.
 */
function scrollWithin(element: Element): void {
  for (let around = element.parentElement; around && around !== document.body; around = around.parentElement) {
    if (!/auto|scroll/.test(getComputedStyle(around).overflowY)) continue;
    const [own, whole] = [element.getBoundingClientRect(), around.getBoundingClientRect()];
    const style = getComputedStyle(element);
    const above = whole.top + Number.parseFloat(style.scrollMarginTop) - own.top;
    const below = own.bottom + Number.parseFloat(style.scrollMarginBottom) - whole.bottom;
    if (above > 0) around.scrollTop -= above;
    else if (below > 0) around.scrollTop += below;
    return;
  }
  element.scrollIntoView({ block: "nearest" });
}
