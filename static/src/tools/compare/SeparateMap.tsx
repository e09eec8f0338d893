/** The second map of a comparison in a separate picture, with the view, the pointer and the cursor of the first. */

import { useLayoutEffect } from "preact/hooks";
import { centreOf } from "../../grid/lattice";
import { paintCell, paintCrosshair } from "../../render/picture/brush";
import { pictureColours } from "../../render/picture/pictureColours";
import type { Store } from "../../store/store";
import { LinkedPicture } from "../picture/LinkedPicture";
import { mapSurface } from "../picture/mapSurface";
import type { Comparison } from "./comparison";

interface SeparateMapProps {
  readonly store: Store;
  readonly comparison: Comparison;
}

export function SeparateMap({ store, comparison }: SeparateMapProps) {
  // Before the picture of both maps is first drawn.
  useLayoutEffect(() => {
    comparison.isApart.value = true;
    return () => {
      comparison.isApart.value = false;
    };
  }, [comparison]);
  return (
    <LinkedPicture
      store={store}
      label="The other map, A. Shift and arrow keys move the cell cursor in both maps; plus and minus zoom, 0 shows everything."
      onTap={(point) => {
        store.pinned.value = point;
      }}
      setUp={(canvas, invalidate) => {
        const surface = mapSurface(
          store,
          canvas,
          invalidate,
          () => [{ map: store.second.peek()?.map.peek() ?? null }],
          (brush) => {
            const [cell, map] = [store.cell.peek(), store.map.peek()];
            if (!cell || !map) return false;
            paintCell(brush, map.geometry, cell.row, cell.col, brush.colours.outline);
            paintCrosshair(brush, centreOf(map.geometry, cell));
            return false;
          },
        );
        return {
          watch: () => {
            void [store.second.value?.map.value, store.second.value?.version.value, store.cell.value];
            void pictureColours.value;
          },
          paint: surface.paint,
        };
      }}
    />
  );
}
