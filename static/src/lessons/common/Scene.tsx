import type { ReadonlySignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { GridGeometry, LaserScan, OccupancyGrid } from "../../grid/occupancyGrid";
import { bearingOf } from "../../grid/textbook";
import type { Pose } from "../../wire/protocol";
import { Stage, type StageTransform } from "./Stage";
import type { Wall } from "./world";

/** Walls as one path. */
export function Walls({
  transform,
  walls,
  tone = "wall",
}: {
  transform: StageTransform;
  walls: readonly Wall[];
  tone?: string;
}) {
  const path = walls.map(
    ([x0, y0, x1, y1]) => `M${transform.x(x0)} ${transform.y(y0)}L${transform.x(x1)} ${transform.y(y1)}`,
  );
  return <path class={tone} d={path.join("")} />;
}

/** At most this many beams are drawn, or they would hide the map. */
const DRAWN = 60;

/** The beams of a scan up to their endpoints; a beam without a return up to the max range. */
export function Beams({ transform, pose, scan }: { transform: StageTransform; pose: Pose; scan: LaserScan }) {
  const from = `M${transform.x(pose[0])} ${transform.y(pose[1])}`;
  const ends: Record<"return" | "none", string[]> = { return: [], none: [] };
  const every = Math.max(1, Math.round(scan.ranges.length / DRAWN));
  scan.ranges.forEach((range, beam) => {
    if (beam % every !== 0) return;
    const angle = pose[2] + bearingOf(scan, beam);
    const z = Number.isFinite(range) ? range : scan.range_max;
    const to = `L${transform.x(pose[0] + z * Math.cos(angle))} ${transform.y(pose[1] + z * Math.sin(angle))}`;
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
  readonly children?: (transform: StageTransform) => ComponentChildren;
}

/** A map with the true walls drawn over it. */
export function Scene({ geometry, label, grid, walls, lines = false, children }: SceneProps) {
  return (
    <Stage geometry={geometry} label={label} grid={grid} lines={lines}>
      {(transform) => (
        <>
          {children?.(transform)}
          <Walls transform={transform} walls={walls} />
        </>
      )}
    </Stage>
  );
}
