/** What the stage shows beside the sections on localization. */

import { compose } from "../../grid/lattice";
import { effectiveNumber } from "../../grid/particleFilter";
import { written } from "../../ui/numbers";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import type { StageTransform } from "../common/Stage";
import { type MarkProps, type Scene, scene } from "../stage/scene";
import { distanceAt, endPoints, isFree, logLikelihood } from "./field";
import { carry, NEAR } from "./kidnap";
import { paintCloud, paintField } from "./paint";
import { continueWalk, scanningAt, supposedAt, TAKEN_AT, walk, weighed } from "./state";

const SCANS = 77;
const sizeOf = (transform: StageTransform): number => Math.max(8, Math.min(22, 0.2 * transform.metre));
const inWords = ([x, y]: Pose): string => `${written(x, 2)} m, ${written(y, 2)} m`;

/** The lines of the scan seen from a pose. */
function Ends({ transform, points, from }: { transform: StageTransform; points: readonly Point[]; from: Pose }) {
  const ends = points.map(([x, y]) => compose(from, [x, y, 0]));
  const [x, y] = [transform.x(from[0]), transform.y(from[1])];
  return (
    <>
      <path
        class="lesson-beam"
        d={ends.map((end) => `M${x} ${y}L${transform.x(end[0])} ${transform.y(end[1])}`).join("")}
      />
      {ends.map((end, i) => (
        <circle
          key={i}
          class={distanceAt(end[0], end[1]) < 0.3 ? "scan-end" : "scan-end off"}
          cx={transform.x(end[0])}
          cy={transform.y(end[1])}
          r={3.5}
        />
      ))}
    </>
  );
}

function ScanningRobot({ transform }: MarkProps) {
  const pose = scanningAt.value;
  return (
    <>
      <Ends transform={transform} points={weighed.value.points} from={pose} />
      <DragHandle
        transform={transform}
        at={[pose[0], pose[1]]}
        label="Robot"
        sentence="Moves the robot; all poses are weighted again by its scan."
        text={inWords(pose)}
        step={0.25}
        onMove={([x, y]) => {
          if (isFree([x, y])) scanningAt.value = [x, y, pose[2]];
        }}
      >
        <RobotShape yaw={pose[2]} size={sizeOf(transform)} />
      </DragHandle>
    </>
  );
}

export const particlesScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: (context, at) => {
      const { poses, weights } = weighed.value;
      paintCloud(context, at, poses, { weights, random: 0 });
    },
    drawing: ScanningRobot,
    caption: () =>
      `${weighed.value.poses.length.toLocaleString("en")} poses, weighted by one scan of ${weighed.value.points.length} beams (size: weight). Their effective number is ${written(effectiveNumber(weighed.value.weights), 0)}: so few beams fit several places.`,
    task: "Drag the robot.",
  });

function SupposedRobot({ transform }: MarkProps) {
  const pose = supposedAt.value;
  return (
    <>
      <Ends transform={transform} points={TAKEN} from={pose} />
      <circle
        class="scan-taken"
        cx={transform.x(TAKEN_AT[0])}
        cy={transform.y(TAKEN_AT[1])}
        r={sizeOf(transform) + 2}
      />
      <DragHandle
        transform={transform}
        at={[pose[0], pose[1]]}
        label="Assumed pose of the scan"
        sentence="Moves the pose from which the scan is laid over the likelihood field; the ring is where it was taken."
        text={`${inWords(pose)}, ${scoreOf(pose)}`}
        step={0.05}
        onMove={([x, y]) => {
          if (isFree([x, y], 0.05)) supposedAt.value = [x, y, pose[2]];
        }}
      >
        <RobotShape yaw={pose[2]} size={sizeOf(transform)} />
      </DragHandle>
    </>
  );
}

const TAKEN = endPoints(TAKEN_AT, 9);
const scoreOf = (pose: Pose): string => `log p(z | x, m) = ${written(logLikelihood(TAKEN, pose), 1)}`;

export const sensorScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: paintField,
    drawing: SupposedRobot,
    caption: () =>
      `The likelihood field (table 6.3): each end point scores by its distance to the nearest wall. Here ${scoreOf(supposedAt.value)}, at the ring ${scoreOf(TAKEN_AT)}.`,
    task: "Drag the robot to where its scan fits.",
  });

function KidnappedRobot({ transform }: MarkProps) {
  const { robot } = walk.value;
  return (
    <DragHandle
      transform={transform}
      at={[robot[0], robot[1]]}
      label="Robot"
      sentence="Carries the robot to another place; the filter is not told."
      text={inWords(robot)}
      step={0.5}
      onMove={([x, y]) => {
        if (isFree([x, y], 0.25)) continueWalk((now) => carry(now, [x, y, now.robot[2]]));
      }}
    >
      <RobotShape yaw={robot[2]} size={sizeOf(transform)} />
    </DragHandle>
  );
}

function kidnappingCaption(): string {
  const { past, particles, random, carried } = walk.value;
  const last = past.at(-1);
  const near = written(100 * (last?.near ?? 1), 0);
  const scans = past.length - past.findLastIndex(({ kidnapped }) => kidnapped);
  const since = carried
    ? "The robot was carried away just now."
    : past.some(({ kidnapped }) => kidnapped)
      ? `The robot was carried away ${scans === 1 ? "before the last scan" : `${scans} scans ago`}.`
      : "The robot is followed.";
  return `${since} ${near} % of the belief is within ${NEAR} m of it; ${random} of ${particles.length} particles are random.`;
}

export const kidnappingScene = (): Scene =>
  scene({
    scans: SCANS,
    overlay: (context, at) => {
      const { particles, weights, random } = walk.value;
      paintCloud(context, at, particles, { weights, random });
    },
    drawing: KidnappedRobot,
    caption: kidnappingCaption,
    task: "Drag the robot away again.",
  });
