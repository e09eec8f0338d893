import type { StageTransform } from "../common/Stage";
import type { Scene, Shown } from "./scene";

/** What each mark on the stage is given: where it is drawn, the scene, and how much of it is shown. */
export interface MarkProps {
  readonly transform: StageTransform;
  readonly scene: Scene;
  readonly shown: Shown;
}
