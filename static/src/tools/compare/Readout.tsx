/** The values of the inspected cell in both maps. */

import { computed, effect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { logOddsAt, stateAt } from "../../grid/cellValues";
import type { MapPicture } from "../../render/map/mapPicture";
import { MAP, SECOND_MAP } from "../../store/layers";
import { cellIn } from "../../store/sessionSignals";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { LiveRegion } from "../../ui/LiveRegion";
import { signed } from "../../ui/numbers";
import type { CellMessage, CellState } from "../../wire/protocol";
import "../readout/readout.css";

/** A cell of one of the maps; `logOdds` is null if it was never observed. */
interface CellReading {
  readonly logOdds: number | null;
  readonly state: CellState | "never observed";
}

/** The cell of a map at a point, with the server's exact value if that is up to date. Null outside the map. */
function cellAt(
  map: MapPicture | null,
  place: readonly [number, number],
  exact: CellMessage | null,
): CellReading | null {
  const cell = cellIn(map, place);
  if (!map || !cell) return null;
  const { geometry } = map;
  const byte = map.cells.at(cell.row, cell.col);
  if (byte === 0) return { logOdds: null, state: "never observed" };
  const coarse = logOddsAt(byte, geometry);
  const isExact = exact?.row === cell.row && exact.col === cell.col && exact.epoch === geometry.epoch;
  const step = (geometry.high - geometry.low) / 254;
  const logOdds = isExact && Math.abs(exact.log_odds - coarse) <= step ? exact.log_odds : coarse;
  return { logOdds, state: stateAt(byte, geometry) };
}

const value = (cell: CellReading | null): string => (cell?.logOdds == null ? "–" : signed(cell.logOdds, 2));

/** Interval between requests for exact values while they change. */
const REQUEST_MS = 150;

interface CompareReadoutProps {
  readonly store: Store;
  /** The log-odds prior if the sum of both maps is shown; null if their difference is. */
  readonly summedOver: number | null;
}

export function CompareReadout({ store, summedOver }: CompareReadoutProps) {
  const both = useMemo(
    () =>
      computed(() => {
        const place = store.probe.value;
        void [store.mapVersion.value, store.second.value?.version.value];
        if (!place) return null;
        const cell = store.cell.value;
        return {
          cell,
          a: cellAt(store.second.value?.map.value ?? null, place, store.inspectedSecond.value),
          b: cellAt(store.map.value, place, store.inspected.value),
        };
      }),
    [store],
  );
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const requested: Record<string, string> = {};
    const request = effect(() => {
      void both.value;
      timer ??= setTimeout(() => {
        timer = undefined;
        const place = store.probe.peek();
        if (!place) return;
        for (const layer of [MAP, SECOND_MAP]) {
          const map = store.layers.grid(layer).map.peek();
          const cell = cellIn(map, place);
          if (!map || !cell) continue;
          const question = `${map.geometry.epoch} ${cell.row} ${cell.col} ${map.cells.at(cell.row, cell.col)}`;
          if (question === requested[layer]) continue;
          requested[layer] = question;
          store.inspect(cell, layer);
        }
      }, REQUEST_MS);
    });
    return () => {
      clearTimeout(timer);
      request();
    };
  }, [store, both]);
  const now = both.value;
  const a = now?.a ?? null;
  const b = now?.b ?? null;
  const result =
    a?.logOdds == null || b?.logOdds == null
      ? null
      : summedOver === null
        ? b.logOdds - a.logOdds
        : a.logOdds + b.logOdds - summedOver;
  const states = now ? `${a?.state ?? "outside A"} → ${b?.state ?? "outside B"}` : "point at a cell";
  const place = store.pinned.value;
  // Announced when another cell is inspected, not when its value changes.
  const at = now?.cell ? `${now.cell.row} ${now.cell.col}` : "";
  const words = useMemo(
    () =>
      now?.cell
        ? `Row ${now.cell.row}, column ${now.cell.col}: A ${a?.state ?? "outside"} ${value(a)}, B ${b?.state ?? "outside"} ${value(b)}`
        : "",
    [at],
  );
  return (
    <div class="readout compare-readout">
      <dl>
        <div>
          <dt>A</dt>
          <dd class="number">{value(a)}</dd>
        </div>
        <div>
          <dt>B</dt>
          <dd class="number">{value(b)}</dd>
        </div>
        <div>
          <dt>{summedOver === null ? "B − A" : "A + B − ℓ₀"}</dt>
          <dd class="number">{result === null ? "–" : signed(result, 2)}</dd>
        </div>
        <div class="readout-last">
          <dt class="visually-hidden">states</dt>
          <dd>{states}</dd>
        </div>
      </dl>
      <span class="readout-why" title="Click a cell, then ask why it has its value in A or in B">
        <Button disabled={!place} onClick={() => store.explain(place)}>
          Why?
        </Button>
      </span>
      <LiveRegion text={words} />
    </div>
  );
}
