import { computed } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { LiveRegion } from "../../../ui/LiveRegion";
import { costOf, meaningOf } from "./meanings";
import "../../../tools/readout/readout.css";

/** The cost of the inspected cell, as text of constant layout and for screen readers. */
export function CostReadout({ store }: { readonly store: Store }) {
  const reading = useMemo(
    () =>
      computed(() => {
        const map = store.map.value;
        const cell = store.cell.value;
        void store.mapVersion.value;
        if (!map || !cell) return null;
        const cost = costOf(map.cells.at(cell.row, cell.col));
        return { row: cell.row, col: cell.col, cost, text: meaningOf(cost) };
      }),
    [store],
  );
  const now = reading.value;
  return (
    <div class="readout">
      <dl>
        <div>
          <dt>row</dt>
          <dd class="number">{now?.row ?? "–"}</dd>
        </div>
        <div>
          <dt>col</dt>
          <dd class="number">{now?.col ?? "–"}</dd>
        </div>
        <div>
          <dt>cost</dt>
          <dd class="number" data-cost={now?.cost}>
            {now?.cost ?? "–"}
          </dd>
        </div>
        <div class="readout-last">
          <dt class="visually-hidden">meaning</dt>
          <dd class="readout-state">{now?.text ?? "point at a cell"}</dd>
        </div>
      </dl>
      <LiveRegion text={now ? `Row ${now.row}, column ${now.col}: cost ${now.cost}, ${now.text}` : ""} />
    </div>
  );
}
