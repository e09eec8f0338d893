/** The two maps of the lab: the true world, and what the robot believes. */

import type { Picture } from "../../render/picture/Picture";
import type { Store } from "../../store/store";
import { CompareOverlay } from "../../tools/compare/CompareOverlay";
import type { Comparison } from "../../tools/compare/comparison";
import { secondMapNames } from "../../tools/compare/SecondMap";
import { ToolHint } from "../../tools/editing/Toolbar";
import { BeliefView } from "../../tools/picture/BeliefView";
import { ComputingMap } from "../../tools/picture/ComputingMap";
import { Plate } from "../../tools/picture/Plate";
import { WorldView } from "../../tools/picture/WorldView";
import { PlacingHint, RobotAnnouncement } from "../../tools/placing/Placing";
import { Readout } from "../../tools/readout/Readout";
import { Button } from "../../ui/Button";
import type { Live } from "../classSession";
import "./stage.css";

interface StageProps {
  readonly session: Live | null;
  /** What the pictures show: the session's store, or a picture from before there is one. */
  readonly shown: Store | null;
  readonly comparison: Comparison | null;
  /** Whether nothing in it can be used. */
  readonly isInert: boolean;
  /** Called with the picture of the map. */
  readonly onPicture: (picture: Picture) => void;
}

export function Stage({ session, shown, comparison, isInert, onPicture }: StageProps) {
  const store = session?.store ?? null;
  return (
    <div class="lab-stage" inert={isInert}>
      <Plate
        title="The world"
        note="ground truth"
        actions={
          <Button
            kind="quiet"
            icon="fit"
            label="Show everything"
            onClick={() => {
              if (store) store.viewHeld.value = false;
            }}
          />
        }
        caption={
          store && (
            <>
              <PlacingHint store={store} />
              <ToolHint store={store} />
              <RobotAnnouncement store={store} />
            </>
          )
        }
      >
        {shown && <WorldView store={shown} />}
      </Plate>
      <Plate title="The belief" note="the map of the robot" caption={store ? <Readout store={store} /> : null}>
        {shown && (shown !== store || comparison) && (
          <BeliefView store={shown} {...(shown === store && comparison && { comparison })} onPicture={onPicture} />
        )}
        {store && comparison && (
          <>
            {store.compared.value && (
              <CompareOverlay comparison={comparison} names={secondMapNames(store.compared.value)} refused={null} />
            )}
            <ComputingMap store={store} />
          </>
        )}
      </Plate>
    </div>
  );
}
