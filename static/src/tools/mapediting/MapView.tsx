/** The picture of a map that is edited. */

import { signal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Picture } from "../../render/picture/Picture";
import { pictureColours } from "../../render/picture/pictureColours";
import type { Store } from "../../store/store";
import { SPEED_LIMITS } from "../costmap/paint";
import { LinkedPicture } from "../picture/LinkedPicture";
import { mapSurface } from "../picture/mapSurface";
import { paintEditing, watchEditing, ZONES, zonesOver } from "./paint";
import { mapEditingOf } from "./state";
import { key, stroke } from "./strokes";

interface MapViewProps {
  readonly store: Store;
  /** Called with the picture. */
  readonly onPicture?: (picture: Picture) => void;
}

export function MapView({ store, onPicture }: MapViewProps) {
  const failure = useMemo(() => signal(""), []);
  const shown = useRef(0);
  useEffect(() => store.layers.subscribe(ZONES), [store]);
  useEffect(() => store.layers.subscribe(SPEED_LIMITS), [store]);
  useSignalEffect(() => {
    // A turn, a crop or another origin puts the map elsewhere.
    const epoch = store.map.value?.geometry.epoch ?? 0;
    if (shown.current !== 0 && epoch !== shown.current) store.viewHeld.value = false;
    shown.current = epoch;
  });
  return (
    <LinkedPicture
      store={store}
      label="The map. Arrow keys move the cell cursor, Enter uses the tool there, Escape puts it away; square brackets change the brush, plus and minus zoom, 0 shows everything."
      onTap={(point) => {
        store.pinned.value = store.pinned.peek() ? null : point;
      }}
      tool={{
        draws: () => mapEditingOf(store).tool.peek() !== null,
        stroke: (from, to, isDone) => stroke(store, from, to, isDone),
        key: (pressed) => key(store, pressed),
      }}
      {...(onPicture ? { onPicture } : {})}
      setUp={(canvas, invalidate) => {
        const surface = mapSurface(
          store,
          canvas,
          invalidate,
          () => [{ map: store.map.peek() }, ...zonesOver(store)],
          (brush) => {
            paintEditing(store, brush);
            return false;
          },
        );
        failure.value = surface.failure;
        return {
          watch: () => {
            void [store.map.value, store.mapVersion.value, store.probe.value, pictureColours.value];
            watchEditing(store);
          },
          paint: surface.paint,
        };
      }}
    >
      {failure.value && <p class="picture-failure">{failure.value}</p>}
    </LinkedPicture>
  );
}
