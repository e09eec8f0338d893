import { useRef } from "preact/hooks";
import { bresenhamSteps } from "../../grid/bresenham";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import type { Point } from "../../wire/protocol";
import { onPath } from "../stage/path";

export const rayFrom = onPath<Point>([4.4, 3.5]);
export const rayTo = onPath<Point>([22.6, 10.7]);

const [DX, DY] = [4, 3];
const LINE = bresenhamSteps({ row: 0, col: 0 }, { row: DY, col: DX }, { direction: true, steep: true });

/** The line from (0, 0) to (4, 3), step by step. */
export function Worked() {
  const room = useRef<HTMLDivElement>(null);
  const rows = LINE.steps.slice(1).map(({ cell }, i) => ({ cell, nabla: LINE.steps[i]?.nabla ?? 0 }));
  return (
    <div class="rays-worked" ref={room}>
      <div class="table-room">
        <table class="plain-table number">
          <caption>
            From (0, 0) to (4, 3): dx = {DX}, 2dy = {2 * DY}, 2dx = {2 * DX}
          </caption>
          <thead>
            <tr>
              <th scope="col">next x</th>
              <th scope="col">error + 2dy</th>
              <th scope="col">at least dx?</th>
              <th scope="col">y</th>
              <th scope="col">error after</th>
              <th scope="col">∇</th>
            </tr>
          </thead>
          <tbody>
            {rows.map(({ cell, nabla }) => {
              const error = nabla + DX;
              const up = error >= DX;
              return (
                <tr key={cell.col}>
                  <th scope="row">{cell.col}</th>
                  <td>{error}</td>
                  <td>{up ? <b class="noun-hit">yes: y + 1, − 2dx</b> : <b class="noun-miss">no</b>}</td>
                  <td>{cell.row}</td>
                  <td>{written(up ? error - 2 * DX : error, 0)}</td>
                  <td>{written(nabla, 0)}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
      <p class="no-print">
        <Button
          onClick={() => {
            rayFrom.value = [0.5, 0.5];
            rayTo.value = [DX + 0.5, DY + 0.5];
            room.current?.closest(".lesson")?.querySelector(".lesson-figure")?.scrollIntoView({ block: "nearest" });
          }}
        >
          Draw this line in the figure
        </Button>
      </p>
    </div>
  );
}
