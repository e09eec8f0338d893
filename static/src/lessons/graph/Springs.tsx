import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { compose } from "../../grid/lattice";
import { linePath } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { reducedMotion } from "../../ui/browser/media";
import { Choice } from "../../ui/Choice";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { ToggleOf } from "../../ui/Toggle";
import { LOOP_CONTRADICTS, LOOP_STRAINED } from "../../wire/constants";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { Walls } from "../common/Scene";
import { Stage, type StageTransform } from "../common/Stage";
import { useSeen } from "../common/useSteps";
import "./graph.css";
import { Plot } from "../common/Plot";
import { type GraphEdge, gaussNewtonStep, judge, type Kernel, moved, optimise, robustWeight } from "./solver";
import { BY_ODOMETRY, errorOf, GEOMETRY, ODOMETRY, RIGHT_LOOP, SCANS, WALLS, WRONG_LOOP } from "./world";

const HEIGHT = 152;
const PAD = { left: 34, right: 14, top: 32, bottom: 42 };
/** Standard deviations at the right end. */
const FARTHEST = 30;
const TICKS = [0, 5, 10, 15, 20, 25, 30];

interface KernelPlotProps {
  readonly kernel: Kernel;
  readonly scale: number;
  readonly loops: readonly { readonly name: string; readonly residual: number; readonly weight: number }[];
}

/** The weight that the kernel leaves of a loop, over its residual, with the loops of the graph on the curve. */
function KernelPlot({ kernel, scale, loops }: KernelPlotProps) {
  return (
    <Plot height={HEIGHT} label="Weight of a loop over its residual in standard deviations">
      {(width) => {
        const x = (residual: number): number =>
          PAD.left + (Math.min(residual, FARTHEST) / FARTHEST) * (width - PAD.left - PAD.right);
        const y = (weight: number): number => PAD.top + (1 - weight) * (HEIGHT - PAD.top - PAD.bottom);
        const residuals = Array.from({ length: 121 }, (_, k) => (FARTHEST * k) / 120);
        const curve = residuals.map(
          (residual) => [x(residual), y(robustWeight(kernel, residual * residual, scale))] as const,
        );
        return (
          <>
            <path class="kernel-axes" d={`M${PAD.left} ${PAD.top}V${y(0)}H${width - PAD.right}`} />
            {[0, 1].map((weight) => (
              <text key={weight} x={PAD.left - 6} y={y(weight) + 4} text-anchor="end">
                {weight}
              </text>
            ))}
            {TICKS.map((tick) => (
              <text key={tick} x={x(tick)} y={y(0) + 18} text-anchor="middle">
                {tick}
              </text>
            ))}
            <text x={width - PAD.right} y={HEIGHT - 5} text-anchor="end">
              residual, standard deviations
            </text>
            <text x={0} y={14}>
              weight of a loop
            </text>
            <path class="kernel-curve" d={linePath(curve)} />
            {loops.map(({ name, residual, weight }) => (
              <g key={name} transform={`translate(${x(residual)} ${y(weight)})`}>
                <circle class="kernel-loop" r={5} />
                <text
                  x={residual > 0.7 * FARTHEST ? -9 : 9}
                  y={-4}
                  text-anchor={residual > 0.7 * FARTHEST ? "end" : "start"}
                >
                  {name}
                </text>
              </g>
            ))}
          </>
        );
      }}
    </Plot>
  );
}

const KERNELS: readonly { readonly value: Kernel; readonly label: string }[] = [
  { value: "none", label: "none" },
  { value: "huber", label: "Huber" },
  { value: "cauchy", label: "Cauchy" },
  { value: "geman_mcclure", label: "Geman–McClure" },
];
const SCALE = 3;
/** While a node is dragged. */
const FEW_ITERATIONS = 20;
/** The part of a Gauss–Newton step that a released graph makes in one frame, and the step at which it stands still. */
const PART = 0.2;
const STILL = 2e-3;

interface Held {
  readonly node: number;
  readonly at: Pose;
}

/** A pose graph as springs: drag a node, close the loop, add a wrong one, and choose what a robust kernel does to it. */
export function Springs() {
  const figure = useRef<HTMLElement>(null);
  const seen = useSeen(figure);
  const hasLoop = useSignal(false);
  const hasWrong = useSignal(false);
  const kernel = useSignal<Kernel>("none");
  const scale = useSignal(SCALE);
  const poses = useSignal<readonly Pose[]>(BY_ODOMETRY);
  const held = useSignal<Held | null>(null);
  const isSettling = useSignal(false);
  const edges = useComputed<readonly GraphEdge[]>(() => [
    ...ODOMETRY,
    ...(hasLoop.value ? [RIGHT_LOOP] : []),
    ...(hasWrong.value ? [WRONG_LOOP] : []),
  ]);
  const rest = useComputed(() =>
    optimise(BY_ODOMETRY, edges.value, { kernel: kernel.value, scale: scale.value, fixed: [0] }),
  );
  const judged = useComputed(() => judge(poses.value, edges.value, kernel.value, scale.value));

  // A graph that is not dragged goes to its minimum in Gauss–Newton steps, a part of one in each frame.
  useSignalEffect(() => {
    const { poses: target, weights } = rest.value;
    if (held.value || !seen.value) return;
    if (reducedMotion.value) {
      poses.value = target;
      return;
    }
    isSettling.value = true;
    let frame = 0;
    const relax = (): void => {
      const step = gaussNewtonStep(poses.peek(), edges.peek(), weights, [0]);
      const largest = Math.max(...step.flat().map(Math.abs));
      poses.value = largest < STILL ? target : moved(poses.peek(), step, PART);
      if (largest >= STILL) frame = requestAnimationFrame(relax);
      else isSettling.value = false;
    };
    frame = requestAnimationFrame(relax);
    return () => {
      isSettling.value = false;
      cancelAnimationFrame(frame);
    };
  });

  const hold = (node: number, [x, y]: Point): void => {
    const turn = (held.peek() ?? { at: poses.peek()[node] }).at?.[2] ?? 0;
    held.value = { node, at: [x, y, turn] };
    const start = poses.peek().map((pose, k) => (k === node ? ([x, y, turn] as Pose) : pose));
    const fixed = node === 0 ? [0] : [0, node];
    const options = { kernel: kernel.peek(), scale: scale.peek(), fixed, maxIterations: FEW_ITERATIONS };
    poses.value = optimise(start, edges.peek(), options).poses;
  };
  const release = (): void => {
    held.value = null;
  };
  const reset = (): void => {
    hasLoop.value = false;
    hasWrong.value = false;
    kernel.value = "none";
    scale.value = SCALE;
    poses.value = BY_ODOMETRY;
  };

  const { residuals, weights } = judged.value;
  const energy = residuals.reduce((sum, r, k) => sum + (weights[k] ?? 1) * r * r, 0);
  const at = (edge: GraphEdge): number => edges.value.indexOf(edge);
  const loops = [
    { edge: RIGHT_LOOP, name: "the right loop" },
    { edge: WRONG_LOOP, name: "the wrong loop" },
  ].flatMap(({ edge, name }) =>
    at(edge) < 0 ? [] : [{ name, residual: residuals[at(edge)] ?? 0, weight: weights[at(edge)] ?? 1 }],
  );
  return (
    <figure class="springs stack" aria-label="A pose graph whose measurements are springs" ref={figure}>
      <Stage geometry={GEOMETRY} label="The poses of a drive round a block, the springs between them, and their scans">
        {(transform) => (
          <>
            <Walls transform={transform} walls={WALLS} tone="wall springs-truth" />
            <ScanDots transform={transform} poses={poses.value} />
            {edges.value.map((edge, k) => (
              <Spring
                key={`${edge.i} ${edge.j}`}
                transform={transform}
                poses={poses.value}
                edge={edge}
                residual={residuals[k] ?? 0}
                weight={weights[k] ?? 1}
              />
            ))}
            {poses.value.map((pose, k) => (
              <DragHandle
                key={k}
                transform={transform}
                at={[pose[0], pose[1]]}
                label={`Pose ${k + 1}`}
                sentence="Moves this pose; the springs pull the others along. Released, it goes back."
                text={`x ${written(pose[0], 2)} m, y ${written(pose[1], 2)} m`}
                step={0.3}
                onMove={(point) => hold(k, point)}
                onRelease={release}
              >
                <RobotShape yaw={pose[2]} size={7} />
              </DragHandle>
            ))}
          </>
        )}
      </Stage>
      <p class="legend">
        <SpringKey tone="fits">fits</SpringKey>
        <SpringKey tone="strained">off by {LOOP_STRAINED} σ or more</SpringKey>
        <SpringKey tone="torn">by {LOOP_CONTRADICTS} σ or more</SpringKey>
        <SpringKey tone="fits loop">thick: a loop</SpringKey>
      </p>
      <div class="figure-controls no-print">
        <ToggleOf
          label="Loop"
          sentence="The robot came back to where it began: the scans of the first pose and of the last but one match."
          signal={hasLoop}
        />
        <ToggleOf
          label="Wrong loop"
          sentence="A matcher took the upper corridor for the lower one."
          signal={hasWrong}
        />
        <Choice
          label="Robust kernel"
          options={KERNELS}
          value={kernel.value}
          sentence="How much weight is left to a loop that does not fit the rest."
          onChange={(value) => {
            kernel.value = KERNELS.find((option) => option.value === value)?.value ?? "none";
          }}
        />
        <Slider
          label="Kernel scale"
          sentence="The residual at which a loop has lost a good part of its weight."
          {...bound(scale)}
          initial={SCALE}
          low={0.5}
          high={20}
          step={0.5}
          unit="σ"
          disabled={kernel.value === "none"}
        />
        <Button onClick={reset}>Reset</Button>
      </div>
      <KernelPlot kernel={kernel.value} scale={scale.value} loops={loops} />
      <figcaption class="number">
        {isSettling.value ? "On the way to the solution. " : ""}RMS error of the poses:{" "}
        <b class="springs-error">{written(errorOf(poses.value), 2)} m</b>; Σ {kernel.value !== "none" && <i>w </i>}
        <i>e</i>ᵀ Ω <i>e</i>= {written(energy, energy < 100 ? 1 : 0)}.
        {loops.map(({ name, residual, weight }) => (
          <span key={name}>
            {" "}
            Residual of {name}: {written(residual, 1)} σ, weight {written(weight, 2)}.
          </span>
        ))}
      </figcaption>
    </figure>
  );
}

/** The scans at their poses, as one path of dots. */
function ScanDots({ transform, poses }: { transform: StageTransform; poses: readonly Pose[] }) {
  const dots = SCANS.flatMap((points, k) =>
    points.map(([px, py]) => {
      const [x, y] = compose(poses[k] as Pose, [px, py, 0]);
      return `M${transform.x(x).toFixed(1)} ${transform.y(y).toFixed(1)}h0`;
    }),
  );
  return <path class="springs-dots" d={dots.join("")} />;
}

const COILS = 7;

/** A zigzag line between two points, straight at its ends. */
function zigzag([ax, ay]: Point, [bx, by]: Point, width: number): string {
  const [dx, dy] = [bx - ax, by - ay];
  const length = Math.max(Math.hypot(dx, dy), 1e-6);
  const [ux, uy] = [-dy / length, dx / length];
  const corners = Array.from({ length: COILS }, (_, k) => {
    const [along, across] = [0.2 + (0.6 * (k + 0.5)) / COILS, k % 2 === 0 ? width : -width];
    return `L${(ax + along * dx + across * ux).toFixed(1)} ${(ay + along * dy + across * uy).toFixed(1)}`;
  });
  return `M${ax.toFixed(1)} ${ay.toFixed(1)}${corners.join("")}L${bx.toFixed(1)} ${by.toFixed(1)}`;
}

const toneOf = (residual: number): string =>
  residual < LOOP_STRAINED ? "fits" : residual < LOOP_CONTRADICTS ? "strained" : "torn";

interface SpringProps {
  readonly transform: StageTransform;
  readonly poses: readonly Pose[];
  readonly edge: GraphEdge;
  readonly residual: number;
  readonly weight: number;
}

/** A measured motion as a spring: pale where a kernel leaves it little weight. */
function Spring({ transform, poses, edge, residual, weight }: SpringProps) {
  const [from, to] = [poses[edge.i] as Pose, poses[edge.j] as Pose];
  const place = (pose: Pose): Point => [transform.x(pose[0]), transform.y(pose[1])];
  return (
    <path
      class={`spring ${toneOf(residual)}${edge.isLoop ? " loop" : ""}`}
      style={{ opacity: 0.25 + 0.75 * weight }}
      d={zigzag(place(from), place(to), edge.isLoop ? 6 : 4)}
    />
  );
}

function SpringKey({ tone, children }: { tone: string; children: ComponentChildren }) {
  return (
    <span>
      <svg class="springs-swatch" viewBox="0 0 40 14" aria-hidden="true">
        <path class={`spring ${tone}`} d={zigzag([1, 7], [39, 7], 4)} />
      </svg>{" "}
      {children}
    </span>
  );
}
