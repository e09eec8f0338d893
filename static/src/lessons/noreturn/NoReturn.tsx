import { computed, type Signal, signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { bound } from "../../ui/bound";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import type { Point } from "../../wire/protocol";
import { cellsOf, phantoms } from "../common/counts";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Beams, Scene, Walls } from "../common/Scene";
import { FIRST_PLACE, GEOMETRY, GLASS, mapAt, POLICIES, type Policy, scanAt, WALLS } from "./model";

const NAMES: Record<Policy, string> = {
  ignore: "ignored",
  free: "counted as free",
  hit: "counted as a hit (wrong)",
};

const inside = ([x, y]: Point): Point => [Math.min(8.9, Math.max(0.7, x)), Math.min(5.7, Math.max(0.7, y))];

/** Where the robot is. */
export const robotAt = signal(FIRST_PLACE);

/** The maps of the same scans under three policies; the robot can be dragged in each of them. */
export function NoReturn({ rangeMax }: { rangeMax: Signal<number> }) {
  return (
    <figure class="noreturn" aria-label="Beams without a return, interpreted in three ways">
      <div class="side-by-side three">
        {POLICIES.map((policy) => (
          <Panel key={policy} policy={policy} at={robotAt} rangeMax={rangeMax} />
        ))}
      </div>
      <div class="figure-controls no-print">
        <Slider
          label="Max range of the lidar"
          sentence="Surfaces that are farther away give no return."
          {...bound(rangeMax)}
          initial={3}
          low={1}
          high={9}
          step={0.1}
          unit="m"
        />
      </div>
      <figcaption>Dashed: glass, which returns no beam. Dotted: beams without a return.</figcaption>
    </figure>
  );
}

function Panel({ policy, at, rangeMax }: { policy: Policy; at: Signal<Point>; rangeMax: Signal<number> }) {
  const grid = useMemo(() => computed(() => mapAt(at.value, rangeMax.value, policy)), [at, rangeMax, policy]);
  const scan = scanAt(at.value, rangeMax.value);
  const [x, y] = at.value;
  const wrong = phantoms(grid.value, [...WALLS, ...GLASS], 1.25 * GEOMETRY.resolution).length;
  const where = `${written(x, 1)} m, ${written(y, 1)} m`;
  return (
    <div>
      <h3>{NAMES[policy]}</h3>
      <Scene geometry={GEOMETRY} label={`The map with no returns ${NAMES[policy]}`} grid={grid} walls={WALLS}>
        {(transform) => (
          <>
            <Beams transform={transform} pose={[x, y, 0]} scan={scan} />
            <Walls transform={transform} walls={GLASS} tone="wall glass" />
            <DragHandle
              transform={transform}
              at={at.value}
              label={`Robot, map with no returns ${NAMES[policy]}`}
              sentence="Moves the robot; all three maps are made again from scans at the new position."
              text={where}
              step={0.2}
              onMove={(point) => {
                at.value = inside(point);
              }}
            >
              <RobotShape yaw={0} size={9} />
            </DragHandle>
          </>
        )}
      </Scene>
      <p class="number" aria-live="polite">
        <b class="noun-miss">{cellsOf(grid.value, "free").length}</b> cells free,{" "}
        <b class="noun-hit">{cellsOf(grid.value, "occupied").length}</b> occupied
        {wrong > 0 && `, ${wrong} of them where no wall is`}
      </p>
    </div>
  );
}
