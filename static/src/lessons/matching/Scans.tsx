import type { Pose } from "../../wire/protocol";
import type { StageTransform } from "../common/Stage";
import { type Pairs, type PointScan, placed } from "./model";
import type { Problem } from "./world";

/** The end points of a scan as one path of dots. */
function Dots({ transform, scan, tone }: { transform: StageTransform; scan: PointScan; tone: string }) {
  const dots = Array.from(scan.x, (x, k) =>
    scan.isPoint[k] ? `M${transform.x(x).toFixed(1)} ${transform.y(scan.y[k] ?? 0).toFixed(1)}h0` : "",
  );
  return <path class={`match-dots ${tone}`} d={dots.join("")} />;
}

interface ScansProps {
  readonly transform: StageTransform;
  readonly problem: Problem;
  readonly pose: Pose;
  readonly pairs: Pairs;
  /** The motion that is not known; null if every one is. */
  readonly unknown: readonly [number, number, number] | null;
}

/** Half the length of the arrow of an unknown direction, metres. */
const ARROW = 0.9;

/** Both scans, the pairs of their points as line segments, and the direction that is not known. */
export function Scans({ transform, problem, pose, pairs, unknown }: ScansProps) {
  const { fixed, moving } = problem;
  const now = placed(moving, pose);
  const px = (scan: PointScan, k: number): string =>
    `${transform.x(scan.x[k] ?? 0).toFixed(1)} ${transform.y(scan.y[k] ?? 0).toFixed(1)}`;
  const segments = pairs.ours.map((k, i) => `M${px(now, k)}L${px(fixed, pairs.theirs[i] ?? 0)}`);
  return (
    <>
      <path class="match-pairs" d={segments.join("")} />
      <Dots transform={transform} scan={fixed} tone="fixed" />
      <Dots transform={transform} scan={now} tone="moving" />
      {unknown && <Unknown transform={transform} pose={pose} direction={unknown} />}
    </>
  );
}

function Unknown({
  transform,
  pose,
  direction,
}: {
  transform: StageTransform;
  pose: Pose;
  direction: readonly [number, number, number];
}) {
  const length = Math.hypot(direction[0], direction[1]);
  if (length < 0.1) return null; // a turn
  const angle = Math.atan2(direction[1], direction[0]);
  const at = (far: number, turn: number, back = 0): string =>
    `${transform.x(pose[0] + far * Math.cos(angle) + back * Math.cos(angle + turn))} ${transform.y(pose[1] + far * Math.sin(angle) + back * Math.sin(angle + turn))}`;
  const head = (far: number, back: number): string => `M${at(far, 0.5, back)}L${at(far, 0)}L${at(far, -0.5, back)}`;
  return <path class="match-unknown" d={`M${at(-ARROW, 0)}L${at(ARROW, 0)}${head(ARROW, -0.2)}${head(-ARROW, 0.2)}`} />;
}
