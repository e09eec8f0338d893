/** The second map of the same recording, at the same places of the picture as the first. */

import { useEffect, useMemo } from "preact/hooks";
import { connectSecond } from "../connect";
import { MapRenderer } from "../gl/renderer";
import { centreOf } from "../lattice";
import type { Pose } from "../protocol";
import type { Store } from "../state";
import { brushOn, paintCell, paintCrosshair, paintRobot } from "./picture/brush";
import { inks } from "./picture/inks";
import { LinkedPicture } from "./picture/LinkedPicture";
import { sized } from "./picture/Picture";

interface BesideProps {
  readonly store: Store;
  readonly session: string;
}

/** Where this map has the robot: where the first has it, or, in a map made right, where it is. */
function robotPose(store: Store): Pose | undefined {
  const frame = store.compared.peek()?.with_faults ? store.beliefFrame.peek() : store.frame.peek();
  return frame?.pose;
}

export function Beside({ store, session }: BesideProps) {
  const second = useMemo(() => connectSecond(session), [session]);
  useEffect(() => {
    second.start();
    return () => second.stop();
  }, [second]);
  const { shown } = second;
  return (
    <LinkedPicture
      store={store}
      label="The second map of the same readings. Plus and minus zoom, 0 shows everything."
      onTap={(point) => {
        store.pinned.value = store.pinned.peek() ? null : point;
      }}
      setUp={(canvas, invalidate) => {
        const overlay = document.createElement("canvas");
        let renderer: MapRenderer | null = null;
        try {
          renderer = new MapRenderer(canvas, invalidate);
        } catch {
          renderer = null; // the belief beside it says what is the matter
        }
        let colours: unknown = null;
        return {
          watch: () => {
            void shown.map.value;
            void shown.version.value;
            void store.frame.value;
            void store.probe.value;
            void inks.value;
          },
          paint: (size, ratio, now) => {
            const view = store.view.peek();
            if (!view || !renderer) return false;
            if (colours !== inks.peek()) {
              colours = inks.peek();
              renderer.recolour();
            }
            sized(overlay, canvas.width, canvas.height);
            const brush = brushOn(overlay, size, ratio, view, inks.peek());
            const map = shown.map.peek();
            brush?.ctx.clearRect(0, 0, size.width, size.height);
            const pose = robotPose(store);
            if (brush && pose) paintRobot(brush, pose, false);
            const cell = store.cell.peek();
            const geometry = store.map.peek()?.geometry;
            if (brush && cell && geometry) {
              paintCell(brush, geometry, cell.row, cell.col, brush.inks.ink);
              paintCrosshair(brush, centreOf(geometry, cell));
            }
            return renderer.draw(map, overlay, view, size, now);
          },
        };
      }}
    />
  );
}
