/** The second map of the same recording, in the same view as the first. */

import { useEffect } from "preact/hooks";
import { centreOf } from "../../grid/lattice";
import { type Brush, paintCell, paintCrosshair, paintRobot } from "../../render/picture/brush";
import { pictureColours } from "../../render/picture/pictureColours";
import { SECOND_MAP } from "../../store/layers";
import type { Store } from "../../store/store";
import type { Pose } from "../../wire/protocol";
import { LinkedPicture } from "./LinkedPicture";
import { mapSurface } from "./mapSurface";

/** The robot's pose in this map: that of the first map or, in the map without faults, the true one. */
function robotPose(store: Store): Pose | undefined {
  const frame = store.compared.peek()?.with_faults ? store.beliefFrame.peek() : store.frame.peek();
  return frame?.pose;
}

export function SecondMapView({ store }: { readonly store: Store }) {
  useEffect(() => store.layers.subscribe(SECOND_MAP), [store]);
  const shown = store.layers.grid(SECOND_MAP);
  return (
    <LinkedPicture
      store={store}
      label="The second map of the same readings. Plus and minus zoom, 0 shows everything."
      onTap={(point) => {
        store.pinned.value = store.pinned.peek() ? null : point;
      }}
      setUp={(canvas, invalidate) => {
        // If nothing can be drawn, the view of the first map shows the error.
        const { paint } = mapSurface(
          store,
          canvas,
          invalidate,
          () => [{ map: shown.map.peek() }],
          (brush) => paintOverlay(store, brush),
        );
        return {
          watch: () => {
            void shown.map.value;
            void shown.version.value;
            void store.frame.value;
            void store.probe.value;
            void pictureColours.value;
          },
          paint,
        };
      }}
    />
  );
}

function paintOverlay(store: Store, brush: Brush): boolean {
  const pose = robotPose(store);
  if (pose) paintRobot(brush, pose, false);
  const cell = store.cell.peek();
  const geometry = store.map.peek()?.geometry;
  if (cell && geometry) {
    paintCell(brush, geometry, cell.row, cell.col, brush.colours.outline);
    paintCrosshair(brush, centreOf(geometry, cell));
  }
  return false;
}
