import { computed, type ReadonlySignal, type Signal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { probability } from "../../grid/cellValues";
import { beamModel, INITIAL_PARAMETERS } from "../../grid/sensorModel";
import { toPixel } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { signed, written } from "../../ui/numbers";
import { Plot } from "../common/Plot";
import "./cell.css";
import { type CellEvent, type CellParameters, logOddsHistory, readingsUntil } from "../../grid/sensorModel";
import {
  evidenceScale,
  FREE,
  LogOddsBackground,
  OCCUPIED,
  ReadingTitle,
  readingScale,
  TITLE_PX,
  ZoneNames,
} from "../../render/chart/LogOddsBackground";

const START: readonly CellEvent[] = ["miss", "miss", "hit", "hit", "miss", "hit", "hit", "hit"];
const SHOWN = 26;

const HEIGHT = 260;

interface CellProps {
  readonly parameters: ReadonlySignal<Readonly<Record<string, unknown>>>;
  /** The readings so far, if another part of the page shows them as well. */
  readonly events?: Signal<readonly CellEvent[]>;
}

const stateOf = (value: number): "free" | "unknown" | "occupied" =>
  value > OCCUPIED ? "occupied" : value < FREE ? "free" : "unknown";

/** What the sign of ℓ says: negative, 0 (up to rounding), positive. */
const LIKELIER = [", more likely free", "", ", more likely occupied"];

/** One cell that the reader updates with hits and misses: a step chart of its log-odds between the clamp's limits. */
export function Cell({ parameters, events: given }: CellProps) {
  const values = useMemo(
    () =>
      computed<CellParameters>(() => ({
        ...INITIAL_PARAMETERS,
        clamp: true,
        log_odds_min: -2,
        log_odds_max: 3.5,
        ...(parameters.value as Partial<CellParameters>),
      })),
    [parameters],
  );
  const own = useSignal<readonly CellEvent[]>(START);
  const events = given ?? own;
  const now = values.value;
  const model = beamModel(now);
  const path = logOddsHistory(events.value, now);
  const value = path[path.length - 1] ?? 0;
  const state = stateOf(value);
  const update = (event: CellEvent): void => {
    events.value = [...events.value, event];
  };

  const limits = now.clamp ? [now.log_odds_min, now.log_odds_max] : [];
  const first = Math.max(0, path.length - SHOWN);
  const up = evidenceScale(HEIGHT, limits, path.slice(-SHOWN));
  const y = (evidence: number): number => toPixel(evidence, up);
  const until =
    state === "occupied" ? readingsUntil("miss", value, FREE, now) : readingsUntil("hit", value, OCCUPIED, now);

  return (
    <figure
      class="cell"
      aria-label="One cell, updated with hits and misses"
      aria-keyshortcuts="H M"
      tabIndex={-1} // macOS gives a pressed button no focus: the keys come here then
      onKeyDown={(event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const key = event.key.toLowerCase();
        if (key === "h") update("hit");
        if (key === "m") update("miss");
      }}
    >
      <div class="cell-square" data-state={state} style={{ "--p": `${probability(value) * 100}%` }}>
        <output>
          <b>
            <i>p</i> {written(probability(value), 2)}
          </b>
          <span>{state}</span>
        </output>
      </div>
      <div class="actions cell-buttons">
        <Button onClick={() => update("hit")}>
          <span class="noun-hit">hit {signed(model.hit)}</span>
        </Button>
        <Button onClick={() => update("miss")}>
          <span class="noun-miss">miss {signed(model.miss)}</span>
        </Button>
        <Button
          kind="quiet"
          icon="restart"
          label="Reset the cell"
          onClick={() => {
            events.value = [];
          }}
        />
      </div>
      <Plot height={HEIGHT + TITLE_PX}>
        {(width) => {
          const across = readingScale(width, first, first + SHOWN);
          const x = (i: number): number => toPixel(i, across);
          const stairs = path
            .slice(first)
            .map((evidence, i) => `${i === 0 ? `M${x(first)} ` : "V"}${y(evidence)}H${x(first + i + 1)}`);
          return (
            <>
              <LogOddsBackground width={width} evidence={up} limits={limits} />
              <ReadingTitle width={width} height={HEIGHT} text="readings of the cell" />
              <path class="profile-line" d={stairs.join("")} />
              <ZoneNames width={width} evidence={up} />
              {events.value.slice(-SHOWN + 1).map((event, i, shown) => {
                const at = path.length - shown.length + i;
                return <circle key={at} class={`dot-${event}`} cx={x(at)} cy={y(path[at] ?? 0)} r={4} />;
              })}
            </>
          );
        }}
      </Plot>
      <figcaption>
        ℓ = {written(value, 2)} · odds {written(Math.exp(value), 2)} : 1
        {LIKELIER[Math.sign(Math.round(1e6 * value)) + 1]}
        {until !== null &&
          until > 0 &&
          ` · the map says ${state === "occupied" ? "free" : "occupied"} after ${until} more ${state === "occupied" ? (until === 1 ? "miss" : "misses") : until === 1 ? "hit" : "hits"}`}
      </figcaption>
    </figure>
  );
}
