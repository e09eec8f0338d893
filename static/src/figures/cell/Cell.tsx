import { computed, type ReadonlySignal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { Button } from "../../ui/Button";
import { signed, written } from "../../ui/numbers";
import { toPixel } from "../profile/layout";
import { beamModel, INITIAL, logOdds, probability } from "../profile/model";
import "./cell.css";
import { type CellParameters, type Event, history, readingsUntil } from "./model";

const START: readonly Event[] = ["miss", "miss", "hit", "hit", "miss", "hit", "hit", "hit"];
const SHOWN = 26;
const FREE = logOdds(0.25);
const OCCUPIED = logOdds(0.65);

const WIDTH = 360;
const HEIGHT = 200;

interface CellProps {
  readonly parameters: ReadonlySignal<Readonly<Record<string, unknown>>>;
}

const stateOf = (value: number): "free" | "unknown" | "occupied" =>
  value > OCCUPIED ? "occupied" : value < FREE ? "free" : "unknown";

/** A cell that the reader feeds with hits and misses: its log-odds as a staircase between the clamp's limits. */
export function Cell({ parameters }: CellProps) {
  const values = useMemo(
    () =>
      computed<CellParameters>(() => ({
        ...INITIAL,
        clamp: true,
        log_odds_min: -2,
        log_odds_max: 3.5,
        ...(parameters.value as Partial<CellParameters>),
      })),
    [parameters],
  );
  const events = useSignal<readonly Event[]>(START);
  const now = values.value;
  const model = beamModel(now);
  const path = history(events.value, now);
  const value = path[path.length - 1] ?? 0;
  const state = stateOf(value);
  const feed = (event: Event): void => {
    events.value = [...events.value, event];
  };

  const low = Math.min(-2.6, now.clamp ? now.log_odds_min - 0.5 : -2.6, ...path.slice(-SHOWN));
  const high = Math.max(4, now.clamp ? now.log_odds_max + 0.5 : 4, ...path.slice(-SHOWN));
  const first = Math.max(0, path.length - SHOWN);
  const x = (i: number): number => toPixel(i - first, { low: 0, high: SHOWN, from: 34, to: WIDTH - 8 });
  const y = (evidence: number): number => toPixel(evidence, { low, high, from: HEIGHT - 8, to: 8 });
  const stairs = path
    .slice(first)
    .map((evidence, i) => `${i === 0 ? "M" : "V"}${i === 0 ? `${x(first)} ` : ""}${y(evidence)}H${x(first + i + 1)}`);
  const until =
    state === "occupied" ? readingsUntil("miss", value, FREE, now) : readingsUntil("hit", value, OCCUPIED, now);

  return (
    <figure class="cell" aria-label="One cell, fed with hits and misses">
      <div class="cell-square" data-state={state} style={{ "--p": `${probability(value) * 100}%` }}>
        <output>
          <b>p {written(probability(value), 2)}</b>
          <span>{state}</span>
        </output>
      </div>
      <div class="cell-buttons">
        <Button onClick={() => feed("hit")}>
          <span class="noun-hit">hit {signed(model.hit)}</span>
        </Button>
        <Button onClick={() => feed("miss")}>
          <span class="noun-miss">miss {signed(model.miss)}</span>
        </Button>
        <Button
          kind="quiet"
          icon="restart"
          label="Begin again"
          onClick={() => {
            events.value = [];
          }}
        />
      </div>
      <svg class="cell-chart" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="presentation">
        <rect class="zone-hit" x={34} y={y(high)} width={WIDTH - 42} height={y(OCCUPIED) - y(high)} />
        <rect class="zone-prior" x={34} y={y(OCCUPIED)} width={WIDTH - 42} height={y(FREE) - y(OCCUPIED)} />
        <rect class="zone-miss" x={34} y={y(FREE)} width={WIDTH - 42} height={y(low) - y(FREE)} />
        {now.clamp &&
          [now.log_odds_min, now.log_odds_max].map((limit) => (
            <line key={limit} class="clamp-line" x1={34} x2={WIDTH - 8} y1={y(limit)} y2={y(limit)} />
          ))}
        {[-2, -1, 0, 1, 2, 3].map((tick) => (
          <text key={tick} class="tick" x={28} y={y(tick) + 4} text-anchor="end">
            {tick === 0 ? "0" : signed(tick, 0)}
          </text>
        ))}
        <path class="profile-line" d={stairs.join("")} />
        {events.value.slice(-SHOWN + 1).map((event, i, shown) => {
          const at = path.length - shown.length + i;
          return <circle key={at} class={`dot-${event}`} cx={x(at)} cy={y(path[at] ?? 0)} r={4} />;
        })}
      </svg>
      <figcaption class="quiet">
        ℓ = {written(value, 2)}
        {until !== null &&
          until > 0 &&
          ` · ${until} more ${state === "occupied" ? (until === 1 ? "miss" : "misses") : until === 1 ? "hit" : "hits"} and it counts as ${state === "occupied" ? "free" : "occupied"}`}
      </figcaption>
    </figure>
  );
}
