import type { Store } from "../../../store/store";
import { Doctor, type DoctorState } from "../Doctor";
import { Facts } from "./Facts";

interface OverviewProps {
  readonly store: Store;
  readonly doctor: DoctorState;
  /** Corrects the poses of the log; not for a guest. */
  readonly onCorrectPoses?: () => void;
}

/** What a log opens on: what it is, and what happened in it. */
export function Overview({ store, doctor, onCorrectPoses }: OverviewProps) {
  return (
    <>
      <Facts store={store} />
      <Doctor store={store} doctor={doctor} {...(onCorrectPoses ? { onCorrectPoses } : {})} />
    </>
  );
}
