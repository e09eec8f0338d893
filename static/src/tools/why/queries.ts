/** Requests the explanation of a cell from the server, repeatedly while it is shown and may have changed. */

import { effect } from "@preact/signals";
import type { Store } from "../../store/store";

/** Least time between requests: for another update, for a cell that changed, for an unchanged cell in a new scan. */
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
