/** The values of the inspected cell. */

import { computed, effect, type ReadonlySignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { logOddsAt, probability, shownByteAt, stateAt } from "../../grid/cellValues";
import { hasMapColours } from "../../render/map/palettes";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { LiveRegion } from "../../ui/LiveRegion";
import { signed, written } from "../../ui/numbers";
import type { CellState } from "../../wire/protocol";
import "./readout.css";

/** The texts for the inspected cell. */
interface Reading {
  readonly row: string;
  readonly col: string;
  readonly logOdds: string;
  readonly p: string;
  readonly state: CellState | "never observed" | "";
}

/** No cell is inspected. */
const NOTHING: Reading = { row: "", col: "", logOdds: "", p: "", state: "" };

function readingOf(store: Store): ReadonlySignal<Reading> {
  return computed(() => {
    const map = store.map.value;
    const cell = store.cell.value;
    void store.mapVersion.value;
    if (!map || !cell) return NOTHING;
    const place = { row: String(cell.row), col: String(cell.col) };
    const byte = map.cells.at(cell.row, cell.col);
    if (byte === 0) return { ...place, logOdds: "–", p: "–", state: "never observed" };
    const { geometry } = map;
    const coarse = logOddsAt(byte, geometry);
    // The server's exact value, if it is up to date.
    const exact = store.inspected.value;
    const isExact = exact?.row === cell.row && exact.col === cell.col && exact.epoch === geometry.epoch;
    const isSame = isExact && Math.abs(shownByteAt(exact.log_odds, geometry) - byte) <= 1;
    const value = isSame ? exact.log_odds : coarse;
    return { ...place, logOdds: signed(value, 2), p: written(probability(value), 3), state: stateAt(byte, geometry) };
  });
}

/** Interval between requests for the exact value of a cell while it changes. */
const REQUEST_MS = 150;

/** A cell in words. */
function wordsOf({ row, col, state, logOdds, p }: Reading): string {
  if (row === "") return "";
  const value = logOdds === "–" ? "" : `, log-odds ${logOdds}, probability ${p}`;
  return `Row ${row}, column ${col}: ${state}${value}`;
}

/** Announces the inspected cell when another one is inspected, not when its value changes. */
function CellAnnouncement({ reading }: { readonly reading: ReadonlySignal<Reading> }) {
  const place = useMemo(() => computed(() => `${reading.value.row} ${reading.value.col}`), [reading]);
  void place.value;
  return <LiveRegion text={wordsOf(reading.peek())} />;
}

/** The values of the inspected cell, as text of constant layout and for screen readers. */
export function Readout({ store }: { readonly store: Store }) {
  const reading = useMemo(() => readingOf(store), [store]);
  useEffect(() => {
    let requested = "";
    let timer: ReturnType<typeof setTimeout> | undefined;
    const request = effect(() => {
      const { row, col, logOdds } = reading.value;
      void [row, col, logOdds];
      timer ??= setTimeout(() => {
        timer = undefined;
        const cell = store.cell.peek();
        const map = store.map.peek();
        if (!cell || !map) return;
        const question = `${map.geometry.epoch} ${cell.row} ${cell.col} ${map.cells.at(cell.row, cell.col)}`;
        if (question === requested) return;
        requested = question;
        store.inspect(cell);
      }, REQUEST_MS);
    });
    return () => {
      clearTimeout(timer);
      request();
    };
  }, [store, reading]);
  const field = (name: keyof Reading): ReadonlySignal<string> => computed(() => reading.value[name]);
  const texts = useMemo(
    () => ({ row: field("row"), col: field("col"), logOdds: field("logOdds"), p: field("p"), state: field("state") }),
    [reading],
  );
  const kind = useMemo(() => computed(() => `readout-state ${reading.value.state.replaceAll(" ", "-")}`), [reading]);
  const isNowhere = useMemo(() => computed(() => reading.value === NOTHING), [reading]);
  return (
    <div class="readout">
      <div class="readout-turns">
        <MapLegend store={store} isShown={isNowhere.value} />
        <Values texts={texts} kind={kind} store={store} isShown={!isNowhere.value} />
      </div>
      <CellAnnouncement reading={reading} />
    </div>
  );
}

interface ValuesProps {
  readonly texts: Readonly<Record<keyof Reading, ReadonlySignal<string>>>;
  /** Class of the state's text. */
  readonly kind: ReadonlySignal<string>;
  readonly store: Store;
  readonly isShown: boolean;
}

function Values({ texts, kind, store, isShown }: ValuesProps) {
  return (
    <div class="readout-values" data-shown={isShown}>
      <dl>
        <div>
          <dt>row</dt>
          <dd class="number">{texts.row}</dd>
        </div>
        <div>
          <dt>col</dt>
          <dd class="number">{texts.col}</dd>
        </div>
        <div>
          <dt>log-odds</dt>
          <dd class="number">{texts.logOdds}</dd>
        </div>
        <div>
          <dt>p</dt>
          <dd class="number">{texts.p}</dd>
        </div>
        <div class="readout-last">
          <dt class="visually-hidden">state</dt>
          <dd class={kind}>{texts.state}</dd>
        </div>
      </dl>
      <WhyButton store={store} />
    </div>
  );
}

const LEGEND = [
  ["occupied", "occupied"],
  ["free", "free"],
  ["unknown", "unknown"],
  ["unobserved", "never seen"],
];

/** The meaning of the map's colours, while no cell is inspected. Its space is kept if another grid is shown. */
function MapLegend({ store, isShown }: { readonly store: Store; readonly isShown: boolean }) {
  const name = store.underlay.value;
  const under = name === null ? null : store.layers.grid(name).map.value;
  return (
    <div class="readout-legend" data-shown={isShown}>
      <ul style={{ visibility: under && !hasMapColours(under) ? "hidden" : undefined }}>
        {LEGEND.map(([name, words]) => (
          <li key={name}>
            <span class={`readout-swatch ${name}`} aria-hidden="true" />
            {words}
          </li>
        ))}
      </ul>
      <p>
        <span class="for-mouse">Point at</span>
        <span class="for-finger">Tap</span> a cell for its numbers. RViz draws free cells white.
      </p>
    </div>
  );
}

/** A button that opens the explanation of the pinned cell. */
function WhyButton({ store }: { readonly store: Store }) {
  const isNowhere = useMemo(() => computed(() => !store.pinned.value || !store.cell.value), [store]);
  return (
    <span class="readout-why" title="Click a cell first. Or Shift+click the cell, or press and hold it.">
      <Button disabled={isNowhere.value} onClick={() => store.explain(store.probe.peek())}>
        Why?
      </Button>
    </span>
  );
}
