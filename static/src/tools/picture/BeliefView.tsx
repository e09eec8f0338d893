/** The view of the robot's map. */

import { signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { centreOf } from "../../grid/lattice";
import type { Layer } from "../../render/map/renderer";
import {
  type Brush,
  paintBeam,
  paintBeams,
  paintCell,
  paintCrosshair,
  paintPath,
  paintRobot,
} from "../../render/picture/brush";
import { paintLayer } from "../../render/picture/overlays";
import type { Picture } from "../../render/picture/Picture";
import { pictureColours } from "../../render/picture/pictureColours";
import { scanFade } from "../../render/picture/scanFade";
import type { Store } from "../../store/store";
import { reducedMotion } from "../../ui/browser/media";
import { KINDS } from "../../wire/kinds";
import type { Point } from "../../wire/protocol";
import type { Comparison } from "../compare/comparison";
import { GIVEN_MAP } from "../localization/model";
import { measuringTool } from "../measure/tool";
import { OVERLAYS } from "../parts";
import { paintSteps } from "../steps/paint";
import { crossed, paintBeamCells } from "./beamCells";
import { LinkedPicture } from "./LinkedPicture";
import { mapSurface } from "./mapSurface";

interface BeliefViewProps {
  readonly store: Store;
  /** Called for a click on the map; without it, a click pins the cell. */
  readonly onTap?: (point: Point) => void;
  /** Called for a click first; true if it was handled. */
  readonly takesTap?: (point: Point) => boolean;
  /** Called with the picture. */
  readonly onPicture?: (picture: Picture) => void;
  /** Shows a second map in the same picture. */
  readonly comparison?: Comparison;
}

function pin(store: Store, point: Point): void {
  const cell = store.cellOf(point);
  const pinned = store.pinned.peek() && store.cell.peek();
  const isSame = cell && pinned && cell.row === pinned.row && cell.col === pinned.col;
  store.pinned.value = isSame ? null : point;
}

export function BeliefView({ store, onTap, takesTap, onPicture, comparison }: BeliefViewProps) {
  const failure = useMemo(() => signal(""), []);
  return (
    <LinkedPicture
      store={store}
      label="The robot’s map. Shift and arrow keys move the cell cursor, question mark explains the value of its cell, Escape removes the cursor; plus and minus zoom, 0 shows everything."
      tool={useMemo(() => measuringTool(store), [store])}
      onTap={(point) => {
        if (!takesTap?.(point)) (onTap ?? ((at) => pin(store, at)))(point);
      }}
      {...(onPicture ? { onPicture } : {})}
      setUp={(canvas, invalidate) => {
        const fade = scanFade();
        const surface = mapSurface(
          store,
          canvas,
          invalidate,
          () => {
            const below = underlay(store) ?? comparison?.layers() ?? [{ map: store.map.peek(), hasHighlights: true }];
            return [...below, ...OVERLAYS.flatMap((overlay) => overlay.layers?.(store) ?? [])];
          },
          (brush, now) => paintOverlay(store, brush, fade, now, comparison?.ownPart() ?? [0, 1]),
        );
        failure.value = surface.failure;
        const highlights = surface.renderer?.highlights;
        store.onCellChange = (row, col, now) => {
          if (!reducedMotion.peek()) highlights?.add(row, col, now);
        };
        return {
          watch: () => {
            void store.map.value;
            void store.mapVersion.value;
            void store.layers.contents.value;
            void store.beliefFrame.value;
            void store.trajectory.value;
            void store.cell.value;
            void store.inspectedBeam.value;
            void store.draggedTo.value;
            void store.stepping.value;
            void store.inspected.value;
            for (const overlay of OVERLAYS) overlay.watch(store);
            const under = store.underlay.value;
            if (under) void store.layers.grid(under).version.value;
            void pictureColours.value;
            comparison?.watch();
          },
          paint: surface.paint,
          dispose: () => {
            store.onCellChange = null;
          },
        };
      }}
    >
      {failure.value && <p class="picture-failure">{failure.value}</p>}
    </LinkedPicture>
  );
}

/** The grid shown instead of the map; null for none, or while none was received. */
function underlay(store: Store): readonly [Layer] | null {
  const name = store.underlay.peek();
  const map = name === null ? null : store.layers.grid(name).map.peek();
  return map && [{ map }];
}

/** The path and the beams are painted between the fractions `from` and `to` of the picture's width. */
function paintOverlay(
  store: Store,
  brush: Brush,
  fade: ReturnType<typeof scanFade>,
  now: number,
  [from, to]: readonly [from: number, to: number],
): boolean {
  const { ctx, size } = brush;
  ctx.save();
  ctx.beginPath();
  ctx.rect(from * size.width, 0, (to - from) * size.width, size.height);
  ctx.clip();
  for (const content of store.layers.contents.peek()) paintLayer(brush, content);
  const hasRobot = KINDS[store.hello.peek()?.kind ?? ""]?.hasRobot ?? true;
  const moves = hasRobot && paintScan(store, brush, fade, now);
  ctx.restore();
  for (const overlay of OVERLAYS) overlay.paint?.(store, brush);
  const cell = store.cell.peek();
  const map = store.map.peek();
  if (cell && map) {
    paintCell(brush, map.geometry, cell.row, cell.col, brush.colours.outline);
    paintCrosshair(brush, centreOf(map.geometry, cell));
  }
  return moves;
}

/** Paint the path, the newest scan and the robot; true while the beams fade. */
function paintScan(store: Store, brush: Brush, fade: ReturnType<typeof scanFade>, now: number): boolean {
  const frame = store.beliefFrame.peek();
  const from = store.beliefPose.peek();
  const map = store.map.peek();
  const trajectory = store.trajectory.peek();
  // A map for localization has another frame than poses that do not come from localization.
  if (store.underlay.peek() === GIVEN_MAP && !store.part("localization").message.peek()?.is_on) return false;
  if (trajectory && frame) paintPath(brush, trajectory.poses, Math.ceil(frame.index / trajectory.every));
  let strength = 0;
  if (store.stepping.peek()) paintSteps(store, brush, true);
  else if (frame && from) {
    strength = fade(frame.index, now);
    // Faint, so that the cells under the beams can be seen.
    paintBeams(brush, from, frame, frame.range_max, 0.5 * strength, 1.5);
    const beam = store.inspectedBeam.peek();
    if (beam && map && store.probe.peek()) {
      const cells = crossed(map.geometry, from, beam, frame.range_max, store.mapping.values.peek());
      paintBeamCells(brush, map.geometry, cells);
      paintBeam(brush, from, beam, frame.range_max);
    }
    paintRobot(brush, frame.pose, store.draggedTo.peek() !== null);
  }
  return strength > 0;
}
