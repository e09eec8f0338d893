import { Button } from "../../../ui/Button";
import { type DoctorState, findsDrift } from "../Doctor";
import type { Healing } from "./healing";

interface HealOfferProps {
  readonly doctor: DoctorState;
  readonly healing: Healing;
  readonly onHeal: () => void;
}

/** Beside the title of a log whose poses drift, until they are healed: what is wrong, and the button that corrects it. */
export function HealOffer({ doctor, healing, onHeal }: HealOfferProps) {
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
