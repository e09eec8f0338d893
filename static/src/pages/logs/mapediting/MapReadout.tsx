import { computed } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { stateAt } from "../../../grid/cellValues";
import { centreOf } from "../../../grid/lattice";
import { costOfByte } from "../../../render/map/costColours";
import type { Store } from "../../../store/store";
import { SPEED_LIMITS } from "../../../tools/costmap/paint";
import { ZONES } from "../../../tools/mapediting/paint";
import { LiveRegion } from "../../../ui/LiveRegion";
import "../../../tools/readout/readout.css";

/** The inspected cell of a map, as text of constant layout and for screen readers. */
export function MapReadout({ store }: { readonly store: Store }) {
  const reading = useMemo(
    () =>
      computed(() => {
        const map = store.map.value;
        const cell = store.cell.value;
        void store.mapVersion.value;
        if (!map || !cell) return null;
        const zones = store.layers.grid(ZONES).map.value;
        const isForbidden = zones !== null && zones.cells.at(cell.row, cell.col) > 0;
        const state = stateAt(map.cells.at(cell.row, cell.col), map.geometry);
        const [x, y] = centreOf(map.geometry, cell);
        const limits = store.layers.grid(SPEED_LIMITS).map.value;
        const limit = limits ? costOfByte(limits.cells.at(cell.row, cell.col)) : 0;
        const words = [
          state,
          ...(isForbidden ? ["keepout"] : []),
          ...(limit > 0 && limit <= 100 ? [`speed ${limit} %`] : []),
        ];
        return { x: x.toFixed(2), y: y.toFixed(2), text: words.join(", ") };
      }),
    [store],
  );
  const now = reading.value;
  return (
    <div class="readout">
      <dl>
        <div>
          <dt>x, m</dt>
          <dd class="number">{now?.x ?? "–"}</dd>
        </div>
        <div>
          <dt>y, m</dt>
          <dd class="number">{now?.y ?? "–"}</dd>
        </div>
        <div class="readout-last">
          <dt class="visually-hidden">state</dt>
          <dd class="readout-state" data-state={now?.text}>
            {now?.text ?? "point at a cell"}
          </dd>
        </div>
      </dl>
      <LiveRegion text={now && store.pinned.value ? `x ${now.x}, y ${now.y}: ${now.text}` : ""} />
    </div>
  );
}
