/** The motion model as a fan of samples: the robot's possible poses after a motion of the odometry, to be dragged. */

import { useSignal } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";
import {
  type Normals,
  type OmniAlphas,
  odometryControl,
  odometrySigmas,
  sampleMotion,
  sampleOmni,
} from "../../grid/motionModel";
import { normal, seeded } from "../../grid/random";
import { useDrag } from "../../ui/browser/useDrag";
import { useDrawing } from "../../ui/browser/useDrawing";
import { written } from "../../ui/numbers";
import type { Pose, Values } from "../../wire/protocol";
import "./localization.css";

const HEIGHT = 220;
const SAMPLES = 400;
/** Height of the figure in metres, and the robot's position in its width. */
const METRES = 1.2;
const START = 0.16;
const STEP = 0.05;
const TURN = Math.PI / 36;
const ORIGIN: Pose = [0, 0, 0];
const FIRST: Pose = [0.6, 0.12, 0.3];
const ARROW = 24;

const KEYS: Readonly<Record<string, readonly [x: number, y: number]>> = {
  ArrowLeft: [-STEP, 0],
  ArrowRight: [STEP, 0],
  ArrowUp: [0, STEP],
  ArrowDown: [0, -STEP],
};

const degrees = (angle: number): string => written((angle * 180) / Math.PI, 0);

export function MotionFan({ values }: { readonly values: Values }) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale: zoom } = useDrawing(box, 400).value;
  const end = useSignal<Pose>(FIRST);
  const normals = useMemo(() => {
    const random = seeded(5);
    return Array.from({ length: SAMPLES }, (): Normals => [normal(random), normal(random), normal(random)]);
  }, []);
  const alphas = [1, 2, 3, 4, 5].map((k) => Number(values[`alpha${k}`])) as unknown as OmniAlphas;
  const control = odometryControl(ORIGIN, end.value);
  const sigmas = odometrySigmas(control, alphas);
  const sample = (draws: Normals): Pose =>
    values.robot_model_type === "omni"
      ? sampleOmni(end.value, alphas, draws)
      : sampleMotion(control, sigmas, ORIGIN, draws);
  const scale = HEIGHT / METRES;
  const x = (metres: number): number => START * width + scale * metres;
  const y = (metres: number): number => HEIGHT / 2 - scale * metres;
  const [ex, ey, yaw] = end.value;
  const poses = normals.map(sample);
  const dots = poses.map(([px, py]) => `M${x(px).toFixed(1)} ${y(py).toFixed(1)}h0`).join("");
  const looks = poses
    .filter((_, i) => i % 16 === 0)
    .map(([px, py, a]) => `M${x(px).toFixed(1)} ${y(py).toFixed(1)}l${9 * Math.cos(a)} ${-9 * Math.sin(a)}`)
    .join("");
  const place = ([px, py, a]: Pose): void => {
    const inside = (v: number, low: number, high: number): number => Math.min(high, Math.max(low, v));
    const far = (0.96 - START) * width;
    end.value = [inside(px, (-START * width + 8) / scale, far / scale), inside(py, -0.45 * METRES, 0.45 * METRES), a];
  };
  const begin = (): Pose => end.peek();
  const shifting = useDrag({ begin, move: ([fx, fy, a], dx, dy) => place([fx + dx / scale, fy - dy / scale, a]) });
  const turning = useDrag({
    begin,
    move: ([fx, fy, a], dx, dy) => {
      end.value = [fx, fy, Math.atan2(ARROW * Math.sin(a) - dy, ARROW * Math.cos(a) + dx)];
    },
  });
  return (
    <figure class="motion-fan" ref={box} aria-label="Where the robot may be after a motion">
      <svg class="drawing" style={{ zoom }} role="presentation" width={width} height={HEIGHT}>
        <path class="ground" d={`M0 ${HEIGHT / 2}H${width}`} />
        <path class="told" d={`M${x(0)} ${y(0)}L${x(ex)} ${y(ey)}`} />
        <path class="looks" d={looks} />
        <path class="dots" d={dots} />
        <circle class="start" cx={x(0)} cy={y(0)} r={8} />
        <path class="start-heading" d={`M${x(0)} ${y(0)}h14`} />
        {/* biome-ignore lint/a11y/useSemanticElements: SVG has no buttons */}
        <g
          class="handle tone-robot"
          role="button"
          tabindex={0}
          aria-label={`End of the motion, ${written(ex, 2)} m ahead and ${written(ey, 2)} m to the left; arrow keys move it`}
          {...shifting}
          onKeyDown={(event) => {
            const step = KEYS[event.key];
            if (!step) return;
            event.preventDefault();
            place([ex + step[0], ey + step[1], yaw]);
          }}
        >
          <rect class="handle-grab" x={x(ex) - 18} y={y(ey) - 18} width={36} height={36} />
          <circle class="handle-mark" cx={x(ex)} cy={y(ey)} r={8} />
        </g>
        {/* biome-ignore lint/a11y/useSemanticElements: SVG has no buttons */}
        <g
          class="handle tone-robot"
          role="button"
          tabindex={0}
          aria-label={`Heading at the end, ${degrees(yaw)} degrees; arrow keys turn it`}
          {...turning}
          onKeyDown={(event) => {
            const step = KEYS[event.key];
            if (!step) return;
            event.preventDefault();
            end.value = [ex, ey, yaw + (step[0] < 0 || step[1] > 0 ? TURN : -TURN)];
          }}
        >
          <path class="arm" d={`M${x(ex)} ${y(ey)}l${ARROW * Math.cos(yaw)} ${-ARROW * Math.sin(yaw)}`} />
          <rect
            class="handle-grab"
            x={x(ex) + ARROW * Math.cos(yaw) - 12}
            y={y(ey) - ARROW * Math.sin(yaw) - 12}
            width={24}
            height={24}
          />
          <circle class="handle-mark" cx={x(ex) + ARROW * Math.cos(yaw)} cy={y(ey) - ARROW * Math.sin(yaw)} r={5} />
        </g>
      </svg>
      <figcaption>
        Drag where the odometry puts the robot, and its heading. The dots are {SAMPLES} samples of where it may be.
      </figcaption>
    </figure>
  );
}
