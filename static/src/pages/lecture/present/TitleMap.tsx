import { computed, useSignal } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";
import { useSeen, useSteps } from "../../../lessons/common/useSteps";
import { DRIVE } from "../../../lessons/stage/floor";
import { scene } from "../../../lessons/stage/scene";
import { WorldStage } from "../../../lessons/stage/WorldStage";
import { reducedMotion } from "../../../ui/browser/reducedMotion";

const MS = 180;

/** The map of the lecture's drive, which fills in scan by scan; with reduced motion it is complete. */
export function TitleMap() {
  const root = useRef<HTMLDivElement>(null);
  const count = useSignal(reducedMotion.peek() ? DRIVE.length : 1);
  const playing = useSignal(!reducedMotion.peek());
  const now = useMemo(
    () =>
      computed(() =>
        scene({
          scans: count.value,
          marks: ["beams"],
          caption: `The map after ${count.value} of ${DRIVE.length} scans.`,
        }),
      ),
    [count],
  );
  useSteps(
    playing,
    useSeen(root),
    () => MS,
    () => {
      count.value = Math.min(DRIVE.length, count.peek() + 1);
      playing.value = count.peek() < DRIVE.length;
    },
  );
  return (
    <div class="title-map" ref={root}>
      <WorldStage scene={now} />
    </div>
  );
}
