/** From a reading to a cell: the map's axes, the grid's origin, the robot's pose, the end point and its cell. */

import { cellAt } from "../../grid/lattice";
import { written } from "../../ui/numbers";
import { DragHandle } from "../common/DragHandle";
import { cellSide, originAt, pipelineBeam } from "./controls";
import { FLOOR } from "./floor";
import { readingOf } from "./reading";
import type { MarkProps } from "./scene";

const limited = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

export function Frame({ transform, scene, shown }: MarkProps) {
  const [ox, oy] = originAt.value;
  const side = cellSide.value;
  const reading = readingOf(scene, shown, pipelineBeam.value);
  const columns = Math.ceil((FLOOR.width - ox) / side);
  const rows = Math.ceil((FLOOR.height - oy) / side);
  const [left, top] = [transform.x(ox), transform.y(oy + rows * side)];
  const lines = [
    ...Array.from({ length: columns + 1 }, (_, i) => `M${transform.x(ox + i * side)} ${transform.y(oy)}V${top}`),
    ...Array.from(
      { length: rows + 1 },
      (_, i) => `M${left} ${transform.y(oy + i * side)}H${transform.x(ox + columns * side)}`,
    ),
  ];
  const lattice = { origin: [ox, oy, 0] as const, resolution: side };
  const cell = reading && cellAt(lattice, reading.end[0], reading.end[1]);
  const far = reading ? [transform.x(reading.end[0]), transform.y(reading.end[1])] : [0, 0];
  return (
    <>
      <path class="cell-lines" d={lines.join("")} />
      {reading && cell && (
        <>
          <rect
            class="world-stage-cell hit"
            x={transform.x(ox + cell.col * side)}
            y={transform.y(oy + (cell.row + 1) * side)}
            width={side * transform.metre}
            height={side * transform.metre}
          />
          <path class="world-stage-count" d={`M${transform.x(ox)} ${transform.y(oy)}H${far[0]}V${far[1]}`} />
          <path
            class="world-stage-beam"
            d={`M${transform.x(reading.pose[0])} ${transform.y(reading.pose[1])}L${far[0]} ${far[1]}`}
          />
          <circle class="world-stage-end" cx={far[0]} cy={far[1]} r={6} />
          <text class="world-stage-label beam" x={transform.width - 10} y={24} text-anchor="end">
            ({written(reading.end[0], 2)}, {written(reading.end[1], 2)}) m → column {cell.col}, row {cell.row}
          </text>
        </>
      )}
      <DragHandle
        transform={transform}
        at={originAt.value}
        label="Origin of the grid"
        sentence="Moves the lower left corner of the grid; all columns and rows are counted from it."
        text={`${written(ox, 2)} m, ${written(oy, 2)} m`}
        tone="neutral"
        step={0.1}
        onMove={([x, y]) => {
          originAt.value = [limited(x, 0, 3), limited(y, 0, 2)];
        }}
      >
        <path class="world-stage-origin" d="M-14 0H22M16 -5L22 0L16 5M0 14V-22M-5 -16L0 -22L5 -16" />
      </DragHandle>
    </>
  );
}
