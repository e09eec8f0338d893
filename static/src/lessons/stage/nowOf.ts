import { historyOf } from "./history";
import { planOf, type Scene, type Shown, shownOf } from "./scene";

/** The complete map of a scene, computed at once: for what stands beside the stage. */
export function nowOf(scene: Scene): Shown {
  const plan = planOf(scene);
  const history = historyOf(plan);
  history.advance(plan, () => false);
  return shownOf(history, plan.poses.length, scene);
}
