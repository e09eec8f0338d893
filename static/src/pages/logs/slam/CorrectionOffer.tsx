import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { type DoctorState, findsDrift, standsStill } from "../Doctor";
import type { PoseCorrection } from "./poseCorrection";

interface CorrectionOfferProps {
  readonly store: Store;
  readonly doctor: DoctorState;
  readonly correction: PoseCorrection;
  readonly onCorrectPoses: () => void;
}

/**
 * Beside the title of a log: its examination; if its poses drift or never change, as in a log without poses, a sentence
 * on that with the button that corrects it.
 */
export function CorrectionOffer({ store, doctor, correction, onCorrectPoses }: CorrectionOfferProps) {
  const isStill = standsStill(store.trajectory.value?.poses ?? []);
  if (!isStill && doctor.state.value.kind === "busy") {
    const share = doctor.progress.value?.fraction ?? null;
    return <p class="examination-note quiet">Examining …{share !== null && ` ${Math.floor(100 * share)} %`}</p>;
  }
  if (!(isStill || findsDrift(doctor)) || correction.isUnderWay.value || correction.job.value?.state === "done")
    return null;
  return (
    <div class="correction-offer" role="status">
      <span>{isStill ? "The poses do not move" : "The poses drift"}</span>
      <Button kind="primary" onClick={onCorrectPoses}>
        {isStill ? "Find its poses" : "Heal its poses"}
      </Button>
    </div>
  );
}
