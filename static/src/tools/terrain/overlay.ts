/** The outline of the patch of terrain that is asked about, over the map. */

import { type Brush, paintOutline } from "../../render/picture/brush";
import type { Store } from "../../store/store";

export function paintPatch(store: Store, brush: Brush): void {
  const patch = store.part("terrain").message.peek()?.patch;
  if (!patch || store.underlay.peek()?.startsWith("terrain") !== true) return;
  const [x, y] = patch.centre;
  const { half } = patch;
  paintOutline(
    brush,
    [
      [x - half, y - half],
      [x + half, y - half],
      [x + half, y + half],
      [x - half, y + half],
    ],
    brush.colours.outline,
  );
}

/** Read every signal that is painted here. */
export function watchPatch(store: Store): void {
  void store.part("terrain").message.value;
}
