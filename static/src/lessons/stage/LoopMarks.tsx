import { visited } from "./controls";
import { FIELD, LOOP_GEOMETRY, visitOf } from "./loop";
import type { MarkProps } from "./scene";

/** The loop of table 9.1: the perceptual field outlined, and the cell that is visited now. */
export function LoopMarks({ transform }: MarkProps) {
  const { cols, resolution } = LOOP_GEOMETRY;
  const inside = new Set(FIELD);
  // A border wherever a cell of the field has a neighbour outside it.
  const borders = FIELD.flatMap((i) => {
    const [row, col] = [Math.floor(i / cols), i % cols];
    const [x, y] = [transform.x(col * resolution), transform.y((row + 1) * resolution)];
    const side = transform.cell;
    return [
      inside.has(i - 1) && col > 0 ? "" : `M${x} ${y}v${side}`,
      inside.has(i + 1) ? "" : `M${x + side} ${y}v${side}`,
      inside.has(i + cols) ? "" : `M${x} ${y}h${side}`,
      inside.has(i - cols) ? "" : `M${x} ${y + side}h${side}`,
    ];
  });
  const { cell } = visitOf(Math.max(0, visited.value - 1));
  return (
    <>
      <path class="world-stage-field" d={borders.join("")} />
      <rect
        class="world-stage-selected"
        x={transform.x(cell.col * resolution)}
        y={transform.y((cell.row + 1) * resolution)}
        width={transform.cell}
        height={transform.cell}
      />
    </>
  );
}
