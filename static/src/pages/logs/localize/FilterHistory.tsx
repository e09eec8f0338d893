import { useMemo } from "preact/hooks";
import { momentText } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { Panel } from "../../../ui/Panel";
import type { SeriesAnswer } from "../../../wire/http";
import { Plot } from "../contents/LazyPlot";
import type { FilterHistory } from "./api";

interface FilterHistoryProps {
  readonly store: Store;
  readonly history: FilterHistory;
}

const PLOTS = ["Standard deviation of the place", "Entropy of the particles", "Fit of the scans"] as const;

/** How certain the poses in use are along the log, beside the present scan. */
export function HistoryOfFilter({ store, history }: FilterHistoryProps) {
  const series = useMemo(() => seriesOf(history), [history]);
  const now = store.part("localization").message.value;
  const first = history.first_converged;
  return (
    <Panel title="Along the way">
      <div class="panel-stack">
        <p>
          In <b>{history.map.title}</b>.{" "}
          {first === null
            ? "The particles never agreed on one place."
            : `The particles agree on one place from scan ${first + 1} on.`}
        </p>
        {first !== null && (
          <div class="actions">
            <Button onClick={() => store.goTo(first + 1)}>
              Go to {momentText(store, history.seconds[first] ?? 0, first + 1)}
            </Button>
            <Button kind="quiet" onClick={() => store.goTo(1)}>
              Go to the start, {momentText(store, history.seconds[0] ?? 0, 1)}
            </Button>
          </div>
        )}
        {now?.is_on && (
          <p class="localize-now" role="status">
            {now.is_converged ? (now.is_sure ? "Converged, sure" : "Converged, not sure") : "Not converged"} ·{" "}
            {now.n_particles.toLocaleString("en")} particles · {now.entropy.toFixed(1)} bit · fit {now.fit.toFixed(2)}
          </p>
        )}
        {PLOTS.map((plot) => (
          <Plot key={plot} store={store} series={series} plot={plot} />
        ))}
        <p class="quiet">
          On the map: the particles after the present scan, a sample of them, and the ellipse that has 95 % of the
          estimate’s density; it is dashed where the filter has not converged.
        </p>
      </div>
    </Panel>
  );
}

function seriesOf(history: FilterHistory): SeriesAnswer {
  return {
    topic: "localization",
    type: "",
    samples: history.seconds.length,
    gaps: [],
    times: history.seconds,
    columns: [
      { label: "deviation", unit: "m", plot: PLOTS[0], values: history.deviation_m },
      { label: "entropy", unit: "bit", plot: PLOTS[1], values: history.entropy },
      { label: "fit", unit: "", plot: PLOTS[2], values: history.fit },
    ],
  };
}
