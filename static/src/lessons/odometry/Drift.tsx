import { effect, type Signal, useComputed, useSignal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import type { OccupancyGrid } from "../../grid/occupancyGrid";
import { Button } from "../../ui/Button";
import { printing } from "../../ui/browser/theme";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import type { Point, Pose } from "../../wire/protocol";
import { inSlices } from "../common/inSlices";
import { Scene } from "../common/Scene";
import type { StageTransform } from "../common/Stage";
import { useSeen } from "../common/useSteps";
import {
  byOdometry,
  corrected,
  errorOf,
  GEOMETRY,
  mapAlong,
  type Noise,
  otherEnds,
  TRUTH,
  USUAL,
  WALLS,
} from "./model";
import "./odometry.css";

const DEGREE = Math.PI / 180;

const NONE: readonly Pose[] = TRUTH.slice(0, 1);

/** A drive mapped along the poses of noisy odometry, and along poses that scan matching corrects. */
export function Drift({ noise }: { readonly noise: Signal<Noise> }) {
  const figure = useRef<HTMLElement>(null);
  const seen = useSeen(figure);
  const raw = useComputed(() => byOdometry(noise.value));
  const rawMap = useComputed(() => mapAlong(raw.value));
  const ends = useComputed(() => otherEnds(noise.value));
  const matched = useSignal<readonly Pose[]>(NONE);
  const matchedMap = useSignal<OccupancyGrid>(mapAlong(NONE));

  // In a layout effect: a figure that is rendered to be printed is painted before other effects.
  useLayoutEffect(
    () =>
      effect(() => {
        const size = noise.value;
        const isPrinted = printing.value;
        if (!seen.value && !isPrinted) return;
        let poses = NONE;
        const match = (): boolean => {
          poses = [...poses, corrected(poses, size)];
          return poses.length < TRUTH.length;
        };
        return inSlices(isPrinted, match, () => {
          matched.value = poses;
          if (poses.length === TRUTH.length) matchedMap.value = mapAlong(poses);
        });
      }),
    [],
  );

  const set = (change: Partial<Noise>): void => {
    noise.value = { ...noise.peek(), ...change };
  };
  const { way, turn } = noise.value;
  const isDone = matched.value.length === TRUTH.length;
  return (
    <figure
      class="drift stack"
      aria-label="One drive, mapped along its odometry and along corrected poses"
      ref={figure}
    >
      <div class="side-by-side">
        <div>
          <h3>Poses from the odometry</h3>
          <Scene geometry={GEOMETRY} label="The map along the odometry" grid={rawMap} walls={WALLS}>
            {(transform) => (
              <>
                <Ends transform={transform} ends={ends.value} />
                <Path transform={transform} poses={TRUTH} tone="truth" />
                <Path transform={transform} poses={raw.value} tone="raw" />
              </>
            )}
          </Scene>
        </div>
        <div>
          <h3>Each scan matched with those before it</h3>
          <Scene geometry={GEOMETRY} label="The map along the corrected poses" grid={matchedMap} walls={WALLS}>
            {(transform) => (
              <>
                <Path transform={transform} poses={TRUTH} tone="truth" />
                <Path transform={transform} poses={matched.value} tone="matched" />
              </>
            )}
          </Scene>
        </div>
      </div>
      <div class="figure-controls no-print">
        <Slider
          label="Heading error"
          sentence="Standard deviation for each metre driven; independent errors grow with the square root of the distance."
          value={Math.round((10 * turn) / DEGREE) / 10}
          initial={4}
          low={0}
          high={12}
          step={0.5}
          unit="° per m"
          onInput={(value) => set({ turn: value * DEGREE })}
        />
        <Slider
          label="Distance error"
          sentence="Standard deviation for each metre driven, in percent."
          value={Math.round(100 * way)}
          initial={5}
          low={0}
          high={30}
          step={1}
          unit="%"
          onInput={(value) => set({ way: value / 100 })}
        />
        <Button
          onClick={() => {
            noise.value = USUAL;
          }}
        >
          Reset
        </Button>
      </div>
      <figcaption class="number">
        Dashed: the true path. Dots: where {ends.value.length} other drives with the same noise would end. RMS error of
        the poses: <b class="drift-raw">{written(errorOf(raw.value), 2)} m</b> by odometry,{" "}
        <b class="drift-matched awaited-number" data-awaited={isDone ? undefined : ""}>
          {isDone ? `${written(errorOf(matched.value), 2)} m` : "…"}
        </b>{" "}
        corrected.
      </figcaption>
    </figure>
  );
}

interface PathProps {
  readonly transform: StageTransform;
  readonly poses: readonly Pose[];
  readonly tone: string;
}

function Path({ transform, poses, tone }: PathProps) {
  const places = poses.map(([x, y], k) => `${k ? "L" : "M"}${transform.x(x).toFixed(1)} ${transform.y(y).toFixed(1)}`);
  return <path class={`drift-path ${tone}`} d={places.join("")} />;
}

function Ends({ transform, ends }: { readonly transform: StageTransform; readonly ends: readonly Point[] }) {
  const dots = ends.map(([x, y]) => `M${transform.x(x).toFixed(1)} ${transform.y(y).toFixed(1)}h0`);
  return <path class="drift-ends" d={dots.join("")} />;
}
