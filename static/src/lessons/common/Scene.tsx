import type { ReadonlySignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { GridGeometry, LaserScan, OccupancyGrid } from "../../grid/occupancyGrid";
import { bearingOf } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { type Place, Stage } from "./Stage";
import type { Wall } from "./world";

/** Walls as one path. */
export function Walls({ place, walls, tone = "wall" }: { place: Place; walls: readonly Wall[]; tone?: string }) {
  const path = walls.map(([x0, y0, x1, y1]) => `M${place.x(x0)} ${place.y(y0)}L${place.x(x1)} ${place.y(y1)}`);
  return <path class={tone} d={path.join("")} />;
}

/** At most this many beams are drawn, or they would hide the map. */
const DRAWN = 60;

/** The beams of a scan up to their endpoints; a beam without a return up to the max range. */
export function Beams({ place, pose, scan }: { place: Place; pose: Pose; scan: LaserScan }) {
  const from = `M${place.x(pose[0])} ${place.y(pose[1])}`;
  const ends: Record<"return" | "none", string[]> = { return: [], none: [] };
  const every = Math.max(1, Math.round(scan.ranges.length / DRAWN));
  scan.ranges.forEach((range, beam) => {
    if (beam % every !== 0) return;
    const angle = pose[2] + bearingOf(scan, beam);
    const z = Number.isFinite(range) ? range : scan.range_max;
    const to = `L${place.x(pose[0] + z * Math.cos(angle))} ${place.y(pose[1] + z * Math.sin(angle))}`;
    ends[Number.isFinite(range) ? "return" : "none"].push(from + to);
  });
  return (
    <>
      <path class="lesson-beam none" d={ends.none.join("")} />
      <path class="lesson-beam" d={ends.return.join("")} />
    </>
  );
}

interface SceneProps {
  readonly geometry: GridGeometry;
  readonly label: string;
  readonly grid: ReadonlySignal<OccupancyGrid>;
  readonly walls: readonly Wall[];
  /** Draw the borders of the cells. */
  readonly lines?: boolean;
  readonly children?: (place: Place) => ComponentChildren;
}

/** A map with the true walls drawn over it. */
export function Scene({ geometry, label, grid, walls, lines = false, children }: SceneProps) {
  return (
    <Stage geometry={geometry} label={label} grid={grid} lines={lines}>
      {(place) => (
        <>
          {children?.(place)}
          <Walls place={place} walls={walls} />
        </>
      )}
    </Stage>
  );
}
