/** The view of the other map of a comparison; without one, a choice of the log's other poses. */

import { useSignal } from "@preact/signals";
import type { Store } from "../../../store/store";
import type { Comparison } from "../../../tools/compare/comparison";
import { SeparateMap } from "../../../tools/compare/SeparateMap";
import { Button } from "../../../ui/Button";
import { Failure } from "../../../ui/Failure";
import type { ComparedMap } from "../../../wire/http";
import { trajectoryLabel } from "../library/describeLog";
import { compareWith, names } from "./sides";

interface OtherMapProps {
  readonly store: Store;
  readonly session: string;
  readonly comparison: Comparison;
}

export function OtherMap({ store, session, comparison }: OtherMapProps) {
  const failure = useSignal<string | null>(null);
  const compared = store.compared.value;
  const trajectory = store.trajectory.value?.name ?? "";
  if (compared) {
    return (
      <div class="viewer-map">
        <SeparateMap store={store} comparison={comparison} />
        <span class="compare-name compare-name-a" data-side="a">
          <b>A</b> {names(compared, trajectory, store.hello.value?.title ?? "").a}
        </span>
      </div>
    );
  }
  const others = (store.hello.value?.log?.trajectories ?? []).filter(({ name }) => name !== trajectory);
  const begin = (other: ComparedMap): void =>
    void compareWith(session, other).then((why) => {
      failure.value = why;
    });
  return (
    <div class="view-scroll">
      <p>
        The second map is A of a comparison: with other poses, such as those that were recorded beside the corrected
        ones, with the present settings while others are tried, or of another log (under "Compare").
      </p>
      <div class="actions">
        {others.map(({ name }) => (
          <Button key={name} onClick={() => begin({ trajectory: name })}>
            With poses: {trajectoryLabel(name)}
          </Button>
        ))}
        <Button onClick={() => begin({ values: store.mapping.values.peek(), trajectory })}>
          With the present settings
        </Button>
      </div>
      <Failure why={failure.value} />
    </div>
  );
}
