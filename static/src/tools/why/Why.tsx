/** Explanation of a cell's value: the beams that updated it and the increment of each. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { useEffect, useId, useMemo, useRef } from "preact/hooks";
import {
  evidenceScale,
  LogOddsBackground,
  ReadingTitle,
  readingScale,
  TITLE_PX,
  ZoneNames,
} from "../../render/chart/LogOddsBackground";
import { toPixel, toValue } from "../../render/chart/scale";
import { MAP, SECOND_MAP } from "../../store/layers";
import { momentText } from "../../store/shownTime";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import type { Contribution, Value, WhyMessage } from "../../wire/protocol";
import { describe, equation, logOddsCurve, sentence, updateOf, verdict } from "./model";
import "./why.css";

/** Least time between requests: for another update, for a changed cell, for an unchanged cell in a new scan. */
const NEW_REQUEST_MS = 120;
const CHANGED_MS = 350;
const UNCHANGED_MS = 1000;

/** The server sends at most this many updates; a request is for a window of them. */
const WINDOW = 300;
const STEP = 100;

/** The last update to request so that the answer contains update `n` and the one before; undefined for the newest. */
export function untilFor(n: number | null, total: number): number | undefined {
  if (n === null || n > total - WINDOW + STEP) return undefined;
  return (Math.ceil(n / STEP) + 1) * STEP;
}

interface Query {
  readonly place: string;
  readonly content: readonly unknown[];
  readonly index: number;
}

/** Keep the explanation in the store up to date; the returned function stops it. */
export function pollWhy(store: Store): () => void {
  let last: Query = { place: "", content: [], index: -1 };
  let lastAt = Number.NEGATIVE_INFINITY;
  let timer: ReturnType<typeof setTimeout> | undefined;

  const query = (): (Query & { readonly send: () => void }) | null => {
    const cell = store.explainedCell.peek();
    const map = store.explainedMap.peek();
    const layer = store.explainedLayer.peek();
    const epoch = map?.geometry.epoch ?? -1;
    if (!cell || !map || epoch < 0) return null;
    const until = untilFor(store.selectedUpdate.peek(), store.why.peek()?.total ?? 0);
    const { row, col } = cell;
    return {
      place: `${layer} ${epoch} ${row} ${col} ${until}`,
      content: [map.cells.at(row, col), store.mapping.values.peek()],
      index: store.frame.peek()?.index ?? 0,
      send: () =>
        store.send({
          type: "why",
          row,
          col,
          epoch,
          layer,
          ...(until === undefined ? {} : { until }),
        }),
    };
  };
  const waitFor = (next: Query): number | null => {
    if (next.place !== last.place) return NEW_REQUEST_MS;
    if (next.content.some((part, i) => part !== last.content[i])) return CHANGED_MS;
    return next.index === last.index ? null : UNCHANGED_MS;
  };
  const send = (): void => {
    const next = query();
    if (!next || waitFor(next) === null) return;
    last = next;
    lastAt = performance.now();
    next.send();
  };
  const stop = effect(() => {
    void [store.explainedCell.value, store.map.value, store.mapVersion.value, store.frame.value?.index];
    void [store.explainedMap.value, store.second.value?.version.value];
    void [store.mapping.values.value, store.selectedUpdate.value];
    const next = query();
    if (!next) last = { place: "", content: [], index: -1 };
    clearTimeout(timer);
    const wait = next && waitFor(next);
    if (wait !== null) timer = setTimeout(send, Math.max(0, lastAt + wait - performance.now()));
  });
  return () => {
    stop();
    clearTimeout(timer);
  };
}

const WIDTH = 400;
const HEIGHT = 150;
/** Updates closer than this are marked at the edges instead of on the line. */
const ROOMY_PX = 7;

interface ChartProps {
  readonly why: WhyMessage;
  readonly selected: ReadonlySignal<Contribution | null>;
  readonly onSelect: (n: number) => void;
}

/** The log-odds of one cell over its updates; the pointer selects one. */
function Chart({ why, selected, onSelect }: ChartProps) {
  const curve = logOddsCurve(why);
  const limits = [why.log_odds_min, why.log_odds_max].filter((limit) => limit !== null);
  const across = readingScale(WIDTH, 0, Math.max(4, why.total) + 0.5);
  const up = evidenceScale(
    HEIGHT,
    limits,
    curve.map(([, value]) => value),
  );
  const x = (n: number): number => toPixel(n, across);
  const y = (value: number): number => toPixel(value, up);
  const paths = { level: "", hit: "", miss: "" };
  for (const [i, [n, value]] of curve.entries()) {
    const [next, after] = curve[i + 1] ?? [why.total + 0.5, value];
    paths.level += `M${x(n)} ${y(value)}H${x(next)}`;
    if (after !== value) paths[after > value ? "hit" : "miss"] += `M${x(next)} ${y(value)}V${y(after)}`;
  }
  const isRoomy = x(1) - x(0) >= ROOMY_PX;
  const at = selected.value;
  const point = (event: PointerEvent & { readonly currentTarget: SVGSVGElement }): void => {
    const box = event.currentTarget.getBoundingClientRect();
    const n = Math.round(toValue(((event.clientX - box.left) / box.width) * WIDTH, across));
    if (why.total > 0) onSelect(Math.min(why.total, Math.max(1, n)));
  };
  return (
    <svg
      class="cell-chart why-chart"
      viewBox={`0 0 ${WIDTH} ${HEIGHT + TITLE_PX}`}
      role="presentation"
      onPointerDown={point}
      onPointerMove={point}
    >
      <LogOddsBackground width={WIDTH} evidence={up} limits={limits} />
      <ReadingTitle width={WIDTH} height={HEIGHT} text="beams through this cell" />
      {at && <line class="why-now" x1={x(at.n)} x2={x(at.n)} y1={up.from} y2={up.to} />}
      <path class="why-level" d={paths.level} />
      <path class="why-miss" d={paths.miss} />
      <path class="why-hit" d={paths.hit} />
      <ZoneNames width={WIDTH} evidence={up} />
      {!isRoomy && (
        <>
          <path class="why-hit" d={rug(why, true, x, up.to)} />
          <path class="why-miss" d={rug(why, false, x, up.from - 5)} />
        </>
      )}
      {isRoomy &&
        why.contributions.map(({ n, hit, log_odds }) => (
          <circle key={n} class={hit ? "dot-hit" : "dot-miss"} cx={x(n)} cy={y(log_odds)} r={2.5} />
        ))}
      {at && <circle class={`why-dot ${at.hit ? "dot-hit" : "dot-miss"}`} cx={x(at.n)} cy={y(at.log_odds)} r={5} />}
    </svg>
  );
}

/** A tick for each hit, or each miss, along an edge, because at the clamp the line alone does not show them. */
function rug(why: WhyMessage, hits: boolean, x: (n: number) => number, top: number): string {
  let path = "";
  for (const { n, hit } of why.contributions) if (hit === hits) path += `M${x(n)} ${top}v5`;
  return path;
}

interface WhyProps {
  readonly store: Store;
}

const useIsOpen = (store: Store): ReadonlySignal<boolean> =>
  useMemo(() => computed(() => store.explainedPoint.value !== null), [store]);

/** The explanation as a group of a dock, and how to request it. */
export function WhyGroup({ store }: WhyProps) {
  if (useIsOpen(store).value) return <Panel store={store} />;
  return (
    <p class="why-hint">
      Shift+click a cell of the map, or press and hold it, to see why it has its value: each beam that passed through it
      or ended in it, and what each one added.
    </p>
  );
}

function Panel({ store }: WhyProps) {
  const panel = useRef<HTMLElement>(null);
  const slider = useRef<HTMLInputElement>(null);
  useEffect(() => {
    const before = document.activeElement;
    // If it was opened by keyboard, the focus moves to the slider; with a mouse it stays on the picture.
    const byKeys = before instanceof HTMLElement && before.matches(":focus-visible");
    if (byKeys) slider.current?.focus({ preventScroll: true });
    // On a phone the group may be below the screen, or behind the bar at its top; if it is visible, nothing moves.
    const top = panel.current?.getBoundingClientRect().top ?? 0;
    const covered = Number.parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0;
    if (top < covered || top > 0.75 * innerHeight) panel.current?.scrollIntoView({ block: "start" });
    const closeOn = (event: KeyboardEvent): void => {
      if (event.key === "Escape" && !event.defaultPrevented) store.explain(null);
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
  const cell = store.explainedCell.value;
  const hitWindow = useHitWindow(store);
  return (
    <section ref={panel} class="why" aria-label="Why this cell has its value">
      <header class="why-head">
        <h2>Why?</h2>
        {cell && (
          <span class="why-place number">
            row {cell.row}, col {cell.col}
          </span>
        )}
        <Button kind="quiet" icon="close" label="Close" onClick={() => store.explain(null)} />
      </header>
      {store.second.value && store.part("comparison").message.value && (
        <Choice
          label="Map"
          bare
          options={MAPS}
          value={store.explainedLayer.value}
          onChange={(layer) => store.explain(store.explainedPoint.peek(), layer)}
        />
      )}
      <p class="why-sentence">{cell ? (why ? sentence(why, newestOf(why), hitWindow.value) : COMPUTING) : OUTSIDE}</p>
      <Announcement store={store} hitWindow={hitWindow} />
      <UpdateHistory store={store} hitWindow={hitWindow} slider={slider} />
    </section>
  );
}

const COMPUTING = "Computing which beams updated this cell …";
const OUTSIDE = "This place is outside the map.";

/** The newest update, if the answer contains it. */
function newestOf(why: WhyMessage): Contribution | null {
  const last = why.contributions[why.contributions.length - 1];
  return last && last.n === why.total ? last : null;
}

/** The two maps of a comparison. */
const MAPS = [
  { value: SECOND_MAP, label: "In A" },
  { value: MAP, label: "In B" },
];

/** A parameter of the map of the explained cell. */
function parameterOf(store: Store, name: string): Value | undefined {
  const secondValue = store.explainedLayer.value === SECOND_MAP ? store.compared.value?.values[name] : undefined;
  return secondValue ?? store.mapping.values.value[name];
}

const useHitWindow = (store: Store): ReadonlySignal<number> =>
  useMemo(() => computed(() => Number(parameterOf(store, "window") ?? 0)), [store]);

/** The label of an update's numbers: the update rule, or, if the model does not add log-odds, their meaning. */
function ruleOf(store: Store, why: WhyMessage | null): string {
  const model = parameterOf(store, "model");
  if (model === "hit_counting") return "ℓ of the counts, and its change:";
  if (model === "moravec_elfes") return "ℓ of the certainties, and its change:";
  return why && why.log_odds_max === null && why.log_odds_min === null ? "ℓ ← ℓ + Δ" : "ℓ ← clamp(ℓ + Δ)";
}

/** The sentence for screen readers, announced once for each cell and not again for each beam. */
function Announcement({ store, hitWindow }: { readonly store: Store; readonly hitWindow: ReadonlySignal<number> }) {
  const announcement = useMemo(() => signal(""), []);
  useEffect(() => {
    let announced = "";
    return effect(() => {
      const why = store.why.value;
      if (!why) return;
      const place = `${why.layer} ${why.epoch} ${why.row} ${why.col}`;
      if (place === announced) return;
      announced = place;
      announcement.value = sentence(why, newestOf(why), hitWindow.peek());
    });
  }, [store, announcement, hitWindow]);
  return (
    <p class="visually-hidden" role="status" aria-live="polite">
      {announcement}
    </p>
  );
}

interface UpdateHistoryProps {
  readonly store: Store;
  readonly hitWindow: ReadonlySignal<number>;
  readonly slider: { current: HTMLInputElement | null };
}

function UpdateHistory({ store, hitWindow, slider }: UpdateHistoryProps) {
  const id = useId();
  const why = store.why.value;
  const contribution = store.selectedContribution.value;
  const total = why?.total ?? 0;
  const n = Math.min(store.selectedUpdate.value ?? total, total);
  const choose = (to: number): void => {
    // null follows the newest update
    store.selectedUpdate.value = to >= total ? null : Math.max(1, to);
  };
  const update = why && contribution && updateOf(why, contribution.n);
  // The session cannot seek to a scan of another log.
  const isOtherLog = store.explainedLayer.value === SECOND_MAP && Boolean(store.compared.value?.log);
  const isLog = store.hello.value?.kind === "log" && !isOtherLog;
  return (
    <div class="why-history stack" hidden={why !== null && total === 0}>
      {why && <Chart why={why} selected={store.selectedContribution} onSelect={choose} />}
      {!why && <div class="why-chart" />}
      <div class="why-slider">
        <Button kind="quiet" icon="stepBack" label="Previous beam" disabled={n <= 1} onClick={() => choose(n - 1)} />
        <input
          ref={slider}
          type="range"
          aria-label="Beams through this cell"
          aria-describedby={id}
          aria-valuetext={
            contribution ? `beam ${n} of ${total}: ${describe(contribution, hitWindow.value)}` : "computing"
          }
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
        <output aria-live="off" class={contribution?.hit ? "noun-hit" : "noun-miss"}>
          {update ? equation(update) : "…"}
        </output>
      </p>
      <div class="why-update">
        <p>
          {why && (
            <b class="number">
              {n} of {total}
            </b>
          )}{" "}
          {contribution ? <ContributionText contribution={contribution} hitWindow={hitWindow.value} /> : "Computing …"}
        </p>
        {isLog && (
          <Button
            disabled={!contribution}
            onClick={() => {
              if (contribution) store.goTo(contribution.scan + 1);
            }}
          >
            {contribution ? `Go to ${momentText(store, contribution.stamp, contribution.scan + 1)}` : "Go to …"}
          </Button>
        )}
      </div>
      {why?.per_scan && <p class="why-note">Per-scan update: each scan counts once, by one of its beams.</p>}
    </div>
  );
}

function ContributionText({
  contribution,
  hitWindow,
}: {
  readonly contribution: Contribution;
  readonly hitWindow: number;
}) {
  const reading = contribution.range === null ? "no return" : `${contribution.range.toFixed(2)} m`;
  return (
    <>
      scan {contribution.scan + 1}
      {contribution.sensor && ` of ${contribution.sensor}`}, beam {contribution.beam + 1},{" "}
      <span class="noun-beam">{reading}</span>:{" "}
      <span class={contribution.hit ? "noun-hit" : "noun-miss"}>{verdict(contribution, hitWindow)}</span>
    </>
  );
}
