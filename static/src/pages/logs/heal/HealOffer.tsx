import { Button } from "../../../ui/Button";
import { type DoctorState, findsDrift } from "../Doctor";
import type { Healing } from "./healing";

interface HealOfferProps {
  readonly doctor: DoctorState;
  readonly healing: Healing;
  readonly onHeal: () => void;
}

/** Beside the title of a log: that it is examined; if its poses drift, that they do, with the button that corrects it. */
export function HealOffer({ doctor, healing, onHeal }: HealOfferProps) {
  if (doctor.state.value.kind === "busy") {
    const share = doctor.progress.value?.fraction ?? null;
    return <p class="examination-note quiet">Examining …{share !== null && ` ${Math.floor(100 * share)} %`}</p>;
  }
  if (!findsDrift(doctor) || healing.isUnderWay.value || healing.job.value?.state === "done") return null;
  return (
    <div class="heal-offer" role="status">
      <span>The poses drift</span>
      <Button kind="primary" onClick={onHeal}>
        Heal its poses
      </Button>
    </div>
  );
}
