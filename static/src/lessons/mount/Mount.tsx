import { computed, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { compose } from "../../grid/lattice";
import type { GridGeometry } from "../../grid/occupancyGrid";
import { Button } from "../../ui/Button";
import { signed, written } from "../../ui/numbers";
import { Toggle } from "../../ui/Toggle";
import type { Point, Pose } from "../../wire/protocol";
import { cellsOf, phantoms } from "../common/counts";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Scene } from "../common/Scene";
import { Stage, type StageTransform } from "../common/Stage";
import { CORRECT, type Correction, GEOMETRY, LIDAR, mapWith, POSES, TRUE_MOUNT, WALLS } from "./model";
import "./mount.css";

const CLOSE: GridGeometry = { resolution: 0.1, rows: 20, cols: 22, origin: [-0.95, -1, 0] };
const STICK = 0.55;
const DEGREE = Math.PI / 180;

const limited = (value: number, most: number): number => Math.min(most, Math.max(-most, value));
const degrees = (yaw: number): string => `${written(yaw / DEGREE, 0)}°`;

const PRESETS: readonly { readonly name: string; readonly correction: Correction }[] = [
  { name: "correct", correction: CORRECT },
  { name: "rotated by 8°", correction: { ...CORRECT, yaw: 8 * DEGREE } },
  { name: "shifted by 0.5 m", correction: { ...CORRECT, x: -0.5 } },
  { name: "upside down", correction: { ...CORRECT, upsideDown: true } },
];

/** The mount that the map is made with, to be dragged, and the resulting map. */
export function Mount() {
  const correction = useSignal<Correction>(PRESETS[1]?.correction ?? CORRECT);
  const grid = useMemo(() => computed(() => mapWith(correction.value)), [correction]);
  const now = correction.value;
  const set = (change: Partial<Correction>): void => {
    correction.value = { ...correction.peek(), ...change };
  };
  const wrong = phantoms(grid.value, WALLS, 1.35 * GEOMETRY.resolution).length;
  const walls = cellsOf(grid.value, "occupied").length;
  return (
    <figure class="mount" aria-label="The mount of the sensor and the resulting map">
      <div class="mount-robot">
        <h3>The mount the map assumes</h3>
        <Stage geometry={CLOSE} label="The robot from above, with its sensor">
          {(transform) => <Robot transform={transform} correction={now} set={set} />}
        </Stage>
      </div>
      <div class="mount-map">
        <h3>Resulting map</h3>
        <Scene geometry={GEOMETRY} label="The map made with this mount" grid={grid} walls={WALLS}>
          {(transform) => (
            <>
              <path
                class="mount-path"
                d={POSES.map(([x, y], i) => `${i === 0 ? "M" : "L"}${transform.x(x)} ${transform.y(y)}`).join("")}
              />
              {POSES.filter((_, i) => i % 3 === 0).map(([x, y, yaw]) => (
                <g key={`${x} ${y}`} transform={`translate(${transform.x(x)} ${transform.y(y)})`}>
                  <RobotShape yaw={yaw} size={6} />
                </g>
              ))}
            </>
          )}
        </Scene>
      </div>
      <div class="figure-controls no-print">
        {PRESETS.map(({ name, correction: preset }) => (
          <Button
            key={name}
            pressed={JSON.stringify(preset) === JSON.stringify(now)}
            onClick={() => {
              correction.value = preset;
            }}
          >
            {name}
          </Button>
        ))}
        <Toggle label="mounted upside down" checked={now.upsideDown} onChange={(upsideDown) => set({ upsideDown })} />
      </div>
      <figcaption class="number" aria-live="polite">
        Mount error: {signed(now.x)} m forward, {signed(now.y)} m to the left, {degrees(now.yaw)}
        {now.upsideDown && ", upside down"}. Of {walls} occupied cells,{" "}
        <b class={wrong > 0 ? "noun-hit" : ""}>{wrong === 0 ? "all lie on walls" : `${wrong} lie where no wall is`}</b>.
      </figcaption>
    </figure>
  );
}

/** The fan of beams, with an arrow in the direction of the sweep. */
function Fan({ transform, pose, over, tone }: { transform: StageTransform; pose: Pose; over: boolean; tone: string }) {
  const r = 0.34;
  const sign = over ? -1 : 1;
  const at = (bearing: number, far = r): string =>
    `${transform.x(pose[0] + far * Math.cos(pose[2] + sign * bearing))} ${transform.y(pose[1] + far * Math.sin(pose[2] + sign * bearing))}`;
  const { angle_min, angle_increment, beams } = LIDAR;
  const last = angle_min + angle_increment * (beams - 1);
  const size = r * transform.metre;
  const head = [0.055, -0.055].map((side) => `M${at(last - 0.02)}L${at(last - 0.18, r + side)}`).join("");
  return (
    <g class={`fan ${tone}`}>
      <path
        class="fan-body"
        d={`M${transform.x(pose[0])} ${transform.y(pose[1])}L${at(angle_min)}A${size} ${size} 0 1 ${over ? 1 : 0} ${at(last)}Z`}
      />
      <path class="fan-sweep" d={`M${at(angle_min)}A${size} ${size} 0 1 ${over ? 1 : 0} ${at(last)}${head}`} />
    </g>
  );
}

interface RobotProps {
  readonly transform: StageTransform;
  readonly correction: Correction;
  readonly set: (change: Partial<Correction>) => void;
}

function Robot({ transform, correction, set }: RobotProps) {
  const { x, y, yaw, upsideDown } = correction;
  const believed = compose(TRUE_MOUNT, [x, y, yaw]);
  const tip: Point = [believed[0] + STICK * Math.cos(yaw), believed[1] + STICK * Math.sin(yaw)];
  const [left, right, top, bottom] = [transform.x(-0.4), transform.x(0.4), transform.y(0.3), transform.y(-0.3)];
  return (
    <>
      <rect class="mount-body" x={left} y={top} width={right - left} height={bottom - top} rx={14} />
      <path
        class="mount-axis"
        d={`M${transform.x(0)} ${transform.y(0)}H${transform.x(0.78)}M${transform.x(0)} ${transform.y(0)}V${transform.y(0.62)}`}
      />
      <text class="mount-name" x={transform.x(0.8)} y={transform.y(-0.09)}>
        x
      </text>
      <text class="mount-name" x={transform.x(-0.07)} y={transform.y(0.6)}>
        y
      </text>
      <text class="mount-label" x={transform.x(-0.37)} y={transform.y(-0.24)}>
        base_link
      </text>
      <Fan transform={transform} pose={TRUE_MOUNT} over={false} tone="truth" />
      <Fan transform={transform} pose={believed} over={upsideDown} tone="belief" />
      <line
        class="mount-stick"
        x1={transform.x(believed[0])}
        y1={transform.y(believed[1])}
        x2={transform.x(tip[0])}
        y2={transform.y(tip[1])}
      />
      <DragHandle
        transform={transform}
        at={[believed[0], believed[1]]}
        label="Position of the sensor"
        sentence="Changes the position of the mount that the map is made with; the readings stay the same."
        text={`${signed(x)} metres forward and ${signed(y)} metres left of its true position`}
        tone="beam"
        step={0.05}
        onMove={(point) =>
          set({ x: limited(point[0] - TRUE_MOUNT[0], 0.7), y: limited(point[1] - TRUE_MOUNT[1], 0.7) })
        }
      />
      <DragHandle
        transform={transform}
        at={tip}
        label="Direction of the sensor"
        sentence="Changes the rotation of the mount that the map is made with; the readings stay the same."
        text={`rotated by ${degrees(yaw)}`}
        tone="beam"
        step={0.05}
        onMove={(point) => set({ yaw: Math.atan2(point[1] - believed[1], point[0] - believed[0]) })}
        onTurn={(by) => set({ yaw: limited(yaw + 5 * by * DEGREE, Math.PI) })}
      >
        <path class="drag-handle-dot" d="M-7 0a7 7 0 1 0 14 0a7 7 0 1 0 -14 0" />
      </DragHandle>
    </>
  );
}
