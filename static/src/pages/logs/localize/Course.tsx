import { useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { Panel } from "../../../ui/Panel";
import { Plot } from "../contents/LazyPlot";
import type { SeriesOfTopic } from "../contents/series";
import type { Course } from "./api";

interface CourseProps {
  readonly store: Store;
  readonly course: Course;
}

const PLOTS = ["Standard deviation of the place", "Entropy of the particles", "Fit of the scans"] as const;

/** How certain the poses in use are along the log, beside the present scan. */
export function CourseOf({ store, course }: CourseProps) {
  const series = useMemo(() => seriesOf(course), [course]);
  const now = store.part("localization").message.value;
  const first = course.first_converged;
  return (
    <Panel title="Along the way">
      <div class="heal">
        <p>
          In <b>{course.map.title}</b>.{" "}
          {first === null
            ? "The particles never agreed on one place."
            : `The particles agree on one place from scan ${first + 1} on.`}
        </p>
        {first !== null && (
          <div class="heal-actions">
            <Button onClick={() => store.goTo(first + 1)}>Show that scan</Button>
            <Button kind="quiet" onClick={() => store.goTo(1)}>
              Show the start
            </Button>
          </div>
        )}
        {now?.is_on && (
          <p class="localize-now" role="status">
            {now.is_converged ? "Converged" : "Not converged"} · {now.n_particles.toLocaleString("en")} particles ·{" "}
            {now.entropy.toFixed(1)} bit · fit {now.fit.toFixed(2)}
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

function seriesOf(course: Course): SeriesOfTopic {
  return {
    topic: "localization",
    type: "",
    samples: course.seconds.length,
    gaps: [],
    times: course.seconds,
    columns: [
      { label: "deviation", unit: "m", plot: PLOTS[0], values: course.deviation_m },
      { label: "entropy", unit: "bit", plot: PLOTS[1], values: course.entropy },
      { label: "fit", unit: "", plot: PLOTS[2], values: course.fit },
    ],
  };
}
