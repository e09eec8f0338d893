/** Why a cell is what it is: every beam that touched it, and what each of them added. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { useEffect, useId, useMemo, useRef } from "preact/hooks";
import { MAP, SECOND_MAP } from "../../store/layers";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import type { Contribution, Value, WhyMessage } from "../../wire/protocol";
import { Chart } from "./Chart";
import { describe, equation, sentence, updateOf, verdict } from "./model";
import { pollWhy } from "./queries";
import "./why.css";

interface WhyProps {
  readonly store: Store;
  /** The side of the window at which the panel lies where there is room for both. */
  readonly side: "left" | "right";
}

/** Opens when a cell is asked about, and stays at the edge of the window: nothing on the page moves. */
export function Why({ store, side }: WhyProps) {
  const isOpen = useMemo(() => computed(() => store.asked.value !== null), [store]);
  return isOpen.value ? <Panel store={store} side={side} /> : null;
}

function Panel({ store, side }: WhyProps) {
  const scrub = useRef<HTMLInputElement>(null);
  useEffect(() => {
    const before = document.activeElement;
    // Whoever came by the keyboard goes on with it; a mouse keeps the picture.
    const byKeys = before instanceof HTMLElement && before.matches(":focus-visible");
    if (byKeys) scrub.current?.focus({ preventScroll: true });
    const closeOn = (event: KeyboardEvent): void => {
      if (event.key === "Escape" && !event.defaultPrevented) store.ask(null);
    };
    addEventListener("keydown", closeOn);
    const stop = pollWhy(store);
    return () => {
      stop();
      removeEventListener("keydown", closeOn);
      if (byKeys) before.focus({ preventScroll: true });
    };
  }, [store]);
  const why = store.why.value;
  const cell = store.askedCell.value;
  const hitWindow = useHitWindow(store);
  return (
    <section class={`why why-${side}`} aria-label="Why this cell is what it is">
      <header class="why-head">
        <h2>Why?</h2>
        {cell && (
          <span class="why-place number">
            row {cell.row}, col {cell.col}
          </span>
        )}
        <Button kind="quiet" icon="close" label="Close" onClick={() => store.ask(null)} />
      </header>
      {store.second.value && store.comparison.value && (
        <Choice
          label="Map"
          bare
          options={MAPS}
          value={store.askedMap.value}
          onChange={(layer) => store.ask(store.asked.peek(), layer)}
        />
      )}
      <p class="why-sentence">{cell ? (why ? sentence(why, newestOf(why), hitWindow.value) : "…") : OUTSIDE}</p>
      <Spoken store={store} hitWindow={hitWindow} />
      <Story store={store} hitWindow={hitWindow} scrub={scrub} />
    </section>
  );
}

const OUTSIDE = "This place is outside the map.";

/** The newest touch, where the answer tells of it. */
function newestOf(why: WhyMessage): Contribution | null {
  const last = why.contributions[why.contributions.length - 1];
  return last && last.n === why.total ? last : null;
}

/** The two maps of a comparison, as the page names them. */
const MAPS = [
  { value: SECOND_MAP, label: "In A" },
  { value: MAP, label: "In B" },
];

/** A parameter of the map that is asked about. */
function parameterOf(store: Store, name: string): Value | undefined {
  const kept = store.askedMap.value === SECOND_MAP ? store.compared.value?.values[name] : undefined;
  return kept ?? store.mapping.values.value[name];
}

const useHitWindow = (store: Store): ReadonlySignal<number> =>
  useMemo(() => computed(() => Number(parameterOf(store, "window") ?? 0)), [store]);

/** What stands before the numbers of an update: the rule, or, where a model keeps no sum, what they are. */
function ruleOf(store: Store, why: WhyMessage | null): string {
  const model = parameterOf(store, "model");
  if (model === "hit_counting") return "ℓ of the counts, and its change:";
  if (model === "moravec_elfes") return "ℓ of the certainties, and its change:";
  return why && why.log_odds_max === null && why.log_odds_min === null ? "ℓ ← ℓ + Δ" : "ℓ ← clamp(ℓ + Δ)";
}

/** The sentence, said once for each cell and not again with each beam. */
function Spoken({ store, hitWindow }: { readonly store: Store; readonly hitWindow: ReadonlySignal<number> }) {
  const spoken = useMemo(() => signal(""), []);
  useEffect(() => {
    let said = "";
    return effect(() => {
      const why = store.why.value;
      if (!why) return;
      const place = `${why.layer} ${why.epoch} ${why.row} ${why.col}`;
      if (place === said) return;
      said = place;
      spoken.value = sentence(why, newestOf(why), hitWindow.peek());
    });
  }, [store, spoken, hitWindow]);
  return (
    <p class="visually-hidden" role="status" aria-live="polite">
      {spoken}
    </p>
  );
}

interface StoryProps {
  readonly store: Store;
  readonly hitWindow: ReadonlySignal<number>;
  readonly scrub: { current: HTMLInputElement | null };
}

function Story({ store, hitWindow, scrub }: StoryProps) {
  const id = useId();
  const why = store.why.value;
  const touch = store.touch.value;
  const total = why?.total ?? 0;
  const n = Math.min(store.touched.value ?? total, total);
  const choose = (to: number): void => {
    // The newest goes on being the newest.
    store.touched.value = to >= total ? null : Math.max(1, to);
  };
  const update = why && touch && updateOf(why, touch.n);
  // Of another log than the session's a scan cannot be gone to.
  const isElsewhere = store.askedMap.value === SECOND_MAP && Boolean(store.compared.value?.log);
  const isLog = store.hello.value?.kind === "log" && !isElsewhere;
  return (
    <div class="why-story" hidden={why !== null && total === 0}>
      {why && <Chart why={why} touch={store.touch} onTouch={choose} />}
      {!why && <div class="why-chart" />}
      <div class="why-scrub">
        <Button kind="quiet" icon="stepBack" label="Previous beam" disabled={n <= 1} onClick={() => choose(n - 1)} />
        <input
          ref={scrub}
          type="range"
          aria-label="Beams through this cell"
          aria-describedby={id}
          aria-valuetext={touch ? `beam ${n} of ${total}: ${describe(touch, hitWindow.value)}` : "no beam yet"}
          min={1}
          max={Math.max(1, total)}
          value={n}
          onInput={(event) => choose(Number(event.currentTarget.value))}
        />
        <span id={id} hidden>
          Steps through the beams that updated this cell and shows the change in log-odds of each.
        </span>
        <Button kind="quiet" icon="stepForward" label="Next beam" disabled={n >= total} onClick={() => choose(n + 1)} />
      </div>
      <p class="why-equation">
        <span class="why-rule">{ruleOf(store, why)}</span>
        <output aria-live="off" class={touch?.hit ? "noun-hit" : "noun-miss"}>
          {update ? equation(update) : "…"}
        </output>
      </p>
      <div class="why-touch">
        <p>
          <b class="number">
            {n} of {total}
          </b>{" "}
          {touch ? <TouchWords touch={touch} hitWindow={hitWindow.value} /> : "…"}
        </p>
        {isLog && (
          <Button
            disabled={!touch}
            onClick={() => {
              if (!touch) return;
              store.send({ type: "pause" });
              store.send({ type: "seek", index: touch.scan + 1 });
            }}
          >
            Go to this scan
          </Button>
        )}
      </div>
      {why?.per_scan && <p class="why-note">Per-scan update: each scan counts once, by one of its beams.</p>}
    </div>
  );
}

function TouchWords({ touch, hitWindow }: { readonly touch: Contribution; readonly hitWindow: number }) {
  const reading = touch.range === null ? "no return" : `${touch.range.toFixed(2)} m`;
  return (
    <>
      scan {touch.scan + 1}, beam {touch.beam + 1}, <span class="noun-beam">{reading}</span>:{" "}
      <span class={touch.hit ? "noun-hit" : "noun-miss"}>{verdict(touch, hitWindow)}</span>
    </>
  );
}
