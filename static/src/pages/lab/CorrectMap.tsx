/** The other map of a comparison in a separate view: the same readings without the faults. */

import type { Store } from "../../store/store";
import type { Comparison } from "../../tools/compare/comparison";
import { secondMapNames } from "../../tools/compare/SecondMap";
import { SeparateMap } from "../../tools/compare/SeparateMap";
import { correctValues } from "../../tools/faults/model";
import { activeNow } from "../../tools/faults/turn";
import { Button } from "../../ui/Button";

interface CorrectMapProps {
  readonly store: Store;
  readonly comparison: Comparison;
}

export function CorrectMap({ store, comparison }: CorrectMapProps) {
  const compared = store.compared.value;
  if (!compared) {
    return (
      <div class="lab-second">
        <p>The map of the same readings without faults, beside the belief.</p>
        <Button onClick={() => store.send({ type: "compare", values: correctValues(activeNow(store).peek()) })}>
          Show the correct map
        </Button>
      </div>
    );
  }
  return (
    <>
      <SeparateMap store={store} comparison={comparison} />
      <span class="compare-name compare-name-a" data-side="a">
        <b>A</b> {secondMapNames(compared).a}
      </span>
    </>
  );
}
