import { written } from "../../ui/numbers";
import { Plot } from "../common/Plot";
import { ValueHandle } from "../common/ValueHandle";
import { laserHeight } from "../stage/controls";
import { LOW_TABLE_HEIGHT } from "../stage/floor";
import "./heights.css";

const HEIGHT = 170;
const FLOOR_Y = HEIGHT - 22;
/** Pixels of a metre, upwards. */
const METRE = 130;
const RANGE = { low: 0.05, high: 1, step: 0.05 };

/** Robot, laser plane and low table from the side; the laser's height can be dragged. */
export function SideView() {
  const now = laserHeight.value;
  const seen = now <= LOW_TABLE_HEIGHT;
  const y = (metres: number): number => FLOOR_Y - metres * METRE;
  return (
    <div class="side-view">
      <Plot height={HEIGHT}>
        {(width) => {
          const [robot, table, wall] = [0.14 * width, 0.5 * width, 0.94 * width];
          const end = seen ? table : wall;
          return (
            <>
              <path class="side-view-floor" d={`M0 ${FLOOR_Y}H${width}`} />
              <rect class="side-view-wall" x={wall} y={8} width={14} height={FLOOR_Y - 8} />
              <rect
                class="side-view-table"
                x={table}
                y={y(LOW_TABLE_HEIGHT)}
                width={0.16 * width}
                height={LOW_TABLE_HEIGHT * METRE}
              />
              <text x={table + 0.08 * width} y={FLOOR_Y + 16} text-anchor="middle">
                low table, {written(LOW_TABLE_HEIGHT, 2)} m
              </text>
              <text x={robot} y={FLOOR_Y + 16} text-anchor="middle">
                robot
              </text>
              <text x={wall + 14} y={FLOOR_Y + 16} text-anchor="end">
                wall
              </text>
              <rect class="side-view-robot" x={robot - 26} y={y(0.22)} width={52} height={0.22 * METRE} rx={6} />
              <path class="side-view-mast" d={`M${robot} ${y(0.22)}V${y(now)}`} />
              <path class="side-view-beam" d={`M${robot + 10} ${y(now)}H${end}`} />
              <circle class="side-view-end" cx={end} cy={y(now)} r={5} />
              <ValueHandle
                label="Laser height"
                sentence="Moves the plane of the laser up or down."
                axis="y"
                tone="tone-beam"
                value={now}
                range={RANGE}
                text={`${written(now, 2)} m`}
                grab={{ x: robot - 24, y: y(now) - 24, width: 48, height: 48 }}
                perPixel={-1 / METRE}
                onValue={(height) => {
                  laserHeight.value = height;
                }}
              >
                <rect class="side-view-laser" x={robot - 10} y={y(now) - 7} width={20} height={14} rx={4} />
              </ValueHandle>
              <text class="side-view-height" x={robot + 16} y={y(now) - 10}>
                laser at {written(now, 2)} m
              </text>
            </>
          );
        }}
      </Plot>
      <p aria-live="polite">
        {seen
          ? "The plane cuts the table: it is measured and mapped."
          : "The plane passes above the table: the laser measures the wall behind it."}
      </p>
    </div>
  );
}
