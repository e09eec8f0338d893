import { computed, effect, type ReadonlySignal, type Signal, useComputed, useSignal } from "@preact/signals";
import { useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import { written } from "../../ui/numbers";
import { Toggle } from "../../ui/Toggle";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import { inSlices } from "../common/inSlices";
import { Walls } from "../common/Scene";
import { Stage, type StageTransform } from "../common/Stage";
import { useSeen } from "../common/useSteps";
import {
  apart,
  ELSEWHERE,
  endOf,
  judged,
  type Method,
  oneStep,
  STARTS,
  scoreAt,
  scoreLandscape,
  snapped,
  TRUE_POSE,
  toTheEnd,
  WINDOW_CELLS,
  WINDOW_TURN,
} from "./matching";
import "./matching.css";
import type { GridGeometry } from "../../grid/occupancyGrid";
import { type Rgb, tokenRgb } from "../../style/colour";
import { isDark, printing } from "../../ui/browser/theme";
import { type Pairs, type PointScan, placed } from "./model";
import { FIELD, GEOMETRY, type Problem, problemIn, type RoomName } from "./world";

const COUNT = STARTS.rows * STARTS.cols;
/** Starts are computed in this order, so that the picture is coarse first: 331 and the number of starts are coprime. */
const STRIDE = 331;

interface Basin {
  /** How the match from each start ends, by cell. */
  readonly ends: Uint8Array;
  readonly done: number;
}

/** The basin of attraction of a method at a heading, computed in slices while the page has no input. */
function useBasin(
  problem: ReadonlySignal<Problem>,
  method: ReadonlySignal<Method>,
  heading: ReadonlySignal<number>,
  seen: ReadonlySignal<boolean>,
): Signal<Basin> {
  const basin = useSignal<Basin>({ ends: new Uint8Array(COUNT), done: 0 });
  // In a layout effect: a figure that is rendered to be printed is painted before other effects.
  useLayoutEffect(
    () =>
      effect(() => {
        const now = [problem.value, method.value, heading.value] as const;
        basin.value = { ends: new Uint8Array(COUNT), done: 0 };
        const isPrinted = printing.value;
        if (!seen.value && !isPrinted) return;
        const ends = new Uint8Array(COUNT);
        let done = 0;
        const matchOne = (): boolean => {
          const index = (done++ * STRIDE) % COUNT;
          ends[index] = endOf(...now, index);
          return done < COUNT;
        };
        return inSlices(isPrinted, matchOne, () => {
          basin.value = { ends: ends.slice(), done };
        });
      }),
    [],
  );
  return basin;
}

type Image = Uint8ClampedArray<ArrayBuffer>;

function painted(
  { rows, cols }: GridGeometry,
  colourOf: (index: number) => readonly [...rgb: Rgb, alpha: number],
): Image {
  void isDark.value; // another theme, other colours
  const image = new Uint8ClampedArray(4 * rows * cols);
  for (let row = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) image.set(colourOf(row * cols + col), 4 * ((rows - 1 - row) * cols + col));
  return image;
}

/** Scores 0 to 1: the shape relative to the highest one, and the paler the lower that is. */
function paintLandscape(scores: Float32Array): Image {
  const rgb = tokenRgb("--beam-fill");
  const highest = Math.max(1e-6, ...scores);
  const strength = 255 * (0.35 + 0.65 * highest);
  return painted(GEOMETRY, (index) => [...rgb, strength * ((scores[index] ?? 0) / highest) ** 2]);
}

/** Starts by how the match ends; those not computed yet in the colour of the page. */
function paintBasin(ends: Uint8Array): Image {
  const [foundColour, elsewhere] = [tokenRgb("--miss-fill"), tokenRgb("--hit-wash")];
  const pending = tokenRgb("--surface");
  return painted(STARTS, (index) => {
    if (ends[index] === TRUE_POSE) return [...foundColour, 255];
    return ends[index] === ELSEWHERE ? [...elsewhere, 255] : [...pending, 255];
  });
}

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
function Scans({ transform, problem, pose, pairs, unknown }: ScansProps) {
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

const DEGREE = Math.PI / 180;
/** Metres from the robot to the handle that turns it. */
const STICK = 0.75;

const METHODS: readonly { readonly value: Method; readonly label: string }[] = [
  { value: "point_to_point", label: "point to point" },
  { value: "point_to_line", label: "point to line" },
  { value: "correlative", label: "correlative" },
];
const ROOMS: readonly { readonly value: RoomName; readonly label: string }[] = [
  { value: "room", label: "a room" },
  { value: "corridor", label: "a corridor" },
  { value: "symmetric", label: "a symmetric room" },
  { value: "table", label: "a room whose table was moved" },
  { value: "far", label: "a start that is too far" },
];

const inside = ([x, y]: Point): Point => [Math.min(6.3, Math.max(0.1, x)), Math.min(4.7, Math.max(0.1, y))];
const degrees = (angle: number, places = 0): string => `${written(angle / DEGREE, places)}°`;
const percent = (share: number): string => `${Math.round(100 * share)} %`;

/** Two scans to be laid one over the other, by hand and by three methods, and the starts from which each finds it. */
export function Matching() {
  const figure = useRef<HTMLElement>(null);
  const seen = useSeen(figure);
  const room = useSignal<RoomName>("room");
  const method = useSignal<Method>("point_to_line");
  const snaps = useSignal(true);
  const problem = useMemo(() => computed(() => problemIn(room.value)), [room]);
  // Where the hand holds the scan, and where it lies: they differ while it is snapped.
  const hand = useSignal<Pose>(problem.peek().start);
  const pose = useSignal<Pose>(problem.peek().start);
  const iterations = useSignal(0);
  const startHeading = useSignal(problem.peek().start[2]);
  const basin = useBasin(problem, method, startHeading, seen);

  const heading = useComputed(() => pose.value[2]);
  const landscapeImage = useComputed(() => paintLandscape(scoreLandscape(problem.value, heading.value)));
  const basinImage = useComputed(() => paintBasin(basin.value.ends));
  const result = useComputed(() => judged(problem.value, pose.value));

  const hold = (next: Pose): void => {
    hand.value = next;
    pose.value = (snaps.peek() && snapped(problem.peek(), method.peek(), next)) || next;
    iterations.value = 0;
  };
  const holdAt = (point: Point): void => hold([...inside(point), hand.peek()[2]]);
  const turnTo = (angle: number): void => {
    hold([hand.peek()[0], hand.peek()[1], angle]);
    startHeading.value = angle;
  };
  const put = (next: Pose, steps: number): void => {
    hand.value = next;
    pose.value = next;
    iterations.value = steps;
  };
  const restart = (): void => {
    const { start } = problem.peek();
    put(start, 0);
    startHeading.value = start[2];
  };

  const now = problem.value;
  const { distance, turn } = apart(pose.value, now.truth);
  const score = scoreAt(now, pose.value);
  const isSnapped = hand.value !== pose.value;
  const correlative = method.value === "correlative";
  const { ends, done } = basin.value;
  const isComplete = done === COUNT;
  const correct = ends.reduce((sum, end) => sum + (end === TRUE_POSE ? 1 : 0), 0);
  const where = `x ${written(hand.value[0], 2)} m, y ${written(hand.value[1], 2)} m, ${isSnapped ? "snapped, " : ""}${written(100 * distance, 1)} cm from the true position`;
  return (
    <figure class="matching stack" aria-label="Two scans, one to be moved over the other" ref={figure}>
      <div class="side-by-side">
        <div>
          <h3>Score at this heading</h3>
          <Stage geometry={GEOMETRY} label="The two scans over the score of every position" colours={landscapeImage}>
            {(transform) => (
              <>
                <Scans
                  transform={transform}
                  problem={now}
                  pose={pose.value}
                  pairs={result.value.pairs}
                  unknown={result.value.unknown}
                />
                {correlative && <SearchWindow transform={transform} at={hand.value} />}
                <Hand
                  transform={transform}
                  hand={hand.value}
                  pose={pose.value}
                  text={where}
                  onMove={holdAt}
                  onTurn={turnTo}
                />
              </>
            )}
          </Stage>
        </div>
        <div>
          <h3>Where each start ends</h3>
          <Stage geometry={STARTS} label="Starting points by where the method ends from there" colours={basinImage}>
            {(transform) => (
              <>
                <Walls transform={transform} walls={now.walls} />
                <g
                  class="match-truth"
                  transform={`translate(${transform.x(now.truth[0])} ${transform.y(now.truth[1])})`}
                >
                  <circle r={6} />
                  <circle r={1.5} />
                </g>
                <DragHandle
                  transform={transform}
                  at={[hand.value[0], hand.value[1]]}
                  label="Starting point"
                  sentence="Moves the scan of the other picture to a starting point."
                  text={where}
                  tone="robot"
                  step={GEOMETRY.resolution}
                  onMove={holdAt}
                >
                  <RobotShape yaw={startHeading.value} size={7} />
                </DragHandle>
              </>
            )}
          </Stage>
          <p class="match-key number">
            <span class="match-swatch found" /> true pose{isComplete && ` ${percent(correct / COUNT)}`}{" "}
            <span class="match-swatch elsewhere" /> another{" "}
            {!isComplete && <span data-awaited="">(the picture fills in)</span>}
          </p>
        </div>
      </div>
      <div class="figure-controls no-print">
        <Choice
          label="Method"
          options={METHODS}
          value={method.value}
          onChange={(value) => {
            method.value = METHODS.find((option) => option.value === value)?.value ?? "point_to_line";
            iterations.value = 0;
          }}
        />
        <Choice
          label="Scans of"
          options={ROOMS}
          value={room.value}
          onChange={(value) => {
            room.value = ROOMS.find((option) => option.value === value)?.value ?? "room";
            restart();
          }}
        />
        <Toggle
          label="Snap"
          sentence="A scan held near the pose at which the method ends is laid there."
          checked={snaps.value}
          onChange={(checked) => {
            snaps.value = checked;
            hold(hand.peek());
          }}
        />
        <Button
          disabled={correlative}
          onClick={() => put(oneStep(now, method.value, pose.value), iterations.value + 1)}
        >
          One iteration
        </Button>
        <Button
          kind="primary"
          onClick={() => {
            const end = toTheEnd(now, method.value, pose.value);
            put(end.pose, iterations.value + end.steps);
          }}
        >
          To the end
        </Button>
        <Button onClick={restart}>Reset</Button>
      </div>
      <figcaption class="number" aria-live="polite">
        {isSnapped && <b>Snapped. </b>}
        {iterations.value > 0 && !correlative && `After ${iterations.value} iterations: `}
        <b class="match-error">
          error {written(100 * distance, 1)} cm, {degrees(turn, 1)}
        </b>
        ; score {percent(score)}; {result.value.pairs.ours.length} pairs.{" "}
        {correlative &&
          `Searched: ±${written(WINDOW_CELLS * FIELD.resolution, 1)} m, ±${WINDOW_TURN}°, in steps of ${written(100 * FIELD.resolution, 0)} cm and 2.5°. `}
        {result.value.unknown && (
          <b class="noun-hit">Degenerate: the pairs do not determine the motion along the arrow.</b>
        )}
      </figcaption>
    </figure>
  );
}

/** The positions that the correlative method searches. */
function SearchWindow({ transform, at }: { transform: StageTransform; at: Pose }) {
  const half = WINDOW_CELLS * FIELD.resolution;
  const side = 2 * half * transform.metre;
  return (
    <rect class="match-window" x={transform.x(at[0] - half)} y={transform.y(at[1] + half)} width={side} height={side} />
  );
}

interface HandProps {
  readonly transform: StageTransform;
  readonly hand: Pose;
  readonly pose: Pose;
  readonly text: string;
  readonly onMove: (point: Point) => void;
  readonly onTurn: (heading: number) => void;
}

/** The handles of the moving scan: one moves it, one turns it. */
function Hand({ transform, hand, pose, text, onMove, onTurn }: HandProps) {
  const tip: Point = [hand[0] + STICK * Math.cos(hand[2]), hand[1] + STICK * Math.sin(hand[2])];
  const line = (to: Point): string =>
    `M${transform.x(hand[0])} ${transform.y(hand[1])}L${transform.x(to[0])} ${transform.y(to[1])}`;
  return (
    <>
      <path class="match-stick" d={line(tip)} />
      <path class="match-offset" d={line([pose[0], pose[1]])} />
      <circle class="match-pose" cx={transform.x(pose[0])} cy={transform.y(pose[1])} r={4} />
      <DragHandle
        transform={transform}
        at={[hand[0], hand[1]]}
        label="Position of the moving scan"
        sentence="Moves the scan; near the pose at which the method ends it snaps."
        text={text}
        step={GEOMETRY.resolution}
        onMove={onMove}
      >
        <RobotShape yaw={hand[2]} size={9} />
      </DragHandle>
      <DragHandle
        transform={transform}
        at={tip}
        label="Heading of the moving scan"
        sentence="Turns the scan about its sensor; arrow keys turn it by 5°, with Shift by 1°."
        text={`heading ${degrees(hand[2])}`}
        step={0.05}
        onMove={([x, y]) => onTurn(Math.atan2(y - hand[1], x - hand[0]))}
        onTurn={(by) => onTurn(hand[2] + 5 * by * DEGREE)}
      >
        <circle class="drag-handle-dot" r={6} />
      </DragHandle>
    </>
  );
}
