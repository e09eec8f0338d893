import { computed, effect, type ReadonlySignal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useId, useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { shownByteAt } from "../../grid/cellValues";
import type { OccupancyGrid } from "../../grid/occupancyGrid";
import {
  evidenceScale,
  FREE,
  LogOddsBackground,
  OCCUPIED,
  readingScale,
  ZoneNames,
} from "../../render/chart/LogOddsBackground";
import { toPixel } from "../../render/chart/scale";
import { mapColours, palette } from "../../render/map/palettes";
import { reducedMotion } from "../../ui/browser/media";
import { isDark } from "../../ui/browser/theme";
import { useSize } from "../../ui/browser/useSize";
import { signed, written } from "../../ui/numbers";
import { Variables } from "../../ui/text/Variables";
import type { Point, Pose } from "../../wire/protocol";
import { DragHandle, RobotShape } from "../common/DragHandle";
import type { StageTransform } from "../common/Stage";
import { distanceTo } from "../common/world";
import { between, eased, type Projection, projection, type Rect, type View } from "./camera";
import { ownCell, ownPoses, ownRobot } from "./controls";
import { FLOOR, POLISHED, TABLE, WALLS } from "./floor";
import { historyOf } from "./history";
import { Marks, World } from "./Marks";
import { planOf, type Scene, type Shown, shownOf } from "./scene";
import "../common/lesson.css";
import "./worldStage.css";

/** Processor time of one animation frame that is spent on scans, ms. */
const SLICE_MS = 7;

/**
 * The map of a scene. When only the number of scans changes, they are added or taken away one after the other; with
 * other conditions the former map stays until the new one is complete. `still` and reduced motion show it at once.
 */
function useStageMap(scene: ReadonlySignal<Scene>, still: boolean): ReadonlySignal<Shown> {
  const plan = useMemo(() => computed(() => planOf(scene.value)), [scene]);
  const first = useMemo(() => {
    const history = historyOf(plan.peek());
    history.advance(plan.peek(), () => false);
    return { history, count: history.count };
  }, [plan]);
  const now = useSignal(first);
  const planned = plan.value;
  // Before the paint, so that a picture that is printed or stands still is never that of another scene.
  const step = (isTimeUp: () => boolean, inSteps: boolean): boolean => {
    const history = historyOf(planned);
    const complete = history.advance(planned, isTimeUp);
    const { history: before, count } = now.peek();
    const target = planned.poses.length;
    if (before !== history) {
      if (complete) now.value = { history, count: target };
      return complete;
    }
    const by = inSteps ? Math.sign(target - count) * Math.ceil(Math.abs(target - count) / 16) : target - count;
    const next = Math.min(count + by, history.count);
    if (next !== count || !complete) now.value = { history, count: next };
    return complete && next === target;
  };
  const atOnce = still || reducedMotion.value;
  useLayoutEffect(() => {
    if (atOnce) step(() => false, false);
  }, [planned, atOnce]);
  useEffect(() => {
    if (atOnce) return;
    let frame = 0;
    let task: ReturnType<typeof setTimeout>;
    const run = (): void => {
      const end = performance.now() + SLICE_MS;
      if (!step(() => performance.now() > end, true)) next();
    };
    // After the paint, so that the handle that changed the scene is painted first.
    const next = (): void => {
      frame = requestAnimationFrame(() => {
        task = setTimeout(run);
      });
    };
    next();
    return () => {
      cancelAnimationFrame(frame);
      clearTimeout(task);
    };
  }, [planned, atOnce]);
  return useMemo(() => computed(() => shownOf(now.value.history, now.value.count, scene.value)), [now, scene]);
}

const TRAVEL_MS = 900;
/** A frame that took longer counts as this long: on a busy machine the way takes more time, and has no jump. */
const LONGEST_MS = 60;

const isSame = (a: View, b: View): boolean =>
  a.x === b.x && a.y === b.y && a.width === b.width && a.height === b.height && a.strip === b.strip;

/** The view on its way to a target; `still` and reduced motion go there at once. */
function useCamera(target: View, still: boolean): ReadonlySignal<View> {
  const now = useSignal(target);
  const atOnce = still || reducedMotion.value;
  const { x, y, width, height, strip } = target;
  useLayoutEffect(() => {
    if (atOnce) now.value = target;
  }, [x, y, width, height, strip, atOnce]);
  useEffect(() => {
    const from = now.peek();
    if (atOnce || isSame(from, target)) return;
    let last = performance.now();
    let travelled = 0;
    let frame = 0;
    const run = (): void => {
      const at = performance.now();
      travelled += Math.min(at - last, LONGEST_MS);
      last = at;
      const t = Math.min(1, travelled / TRAVEL_MS);
      now.value = t < 1 ? between(from, target, eased(t)) : target;
      if (t < 1) frame = requestAnimationFrame(run);
    };
    frame = requestAnimationFrame(run);
    return () => cancelAnimationFrame(frame);
  }, [x, y, width, height, strip, atOnce]);
  return now;
}

interface LadderProps {
  readonly rect: Rect;
  readonly scene: Scene;
  readonly shown: Shown;
}

/** ℓ of the selected cell before the first scan and after each, up to the scan that is shown. */
function Ladder({ rect, scene, shown }: LadderProps) {
  const { history, count, index } = shown;
  if (scene.bare)
    return (
      <g class="world-stage-ladder" transform={`translate(${rect.left} ${rect.top})`}>
        <rect class="world-stage-ladder-ground" width={rect.width} height={rect.height} />
        <text y={rect.height / 2} text-anchor="middle">
          <tspan x={rect.width / 2}>A map of landmarks </tspan>
          <tspan x={rect.width / 2} dy="1.3em">
            has no cells.
          </tspan>
        </text>
      </g>
    );
  const path = scene.ladder ?? (index < 0 ? [0] : history.ladder(index).slice(0, count + 1));
  const limits = scene.config.clamp ? [scene.config.log_odds_min, scene.config.log_odds_max] : [];
  const up = evidenceScale(rect.height, limits, path);
  const across = readingScale(rect.width, 0, Math.max(10, scene.ladder ? 0 : scene.poses.length));
  const x = (i: number): number => toPixel(i, across);
  const y = (l: number): number => toPixel(l, up);
  const line = path.map((l, i) => (i === 0 ? `M${x(0)} ${y(l)}` : `H${x(i)}V${y(l)}`)).join("");
  const last = path.at(-1) ?? 0;
  const isWide = rect.width > 300;
  return (
    <g class="world-stage-ladder" transform={`translate(${rect.left} ${rect.top})`}>
      <rect class="world-stage-ladder-ground" width={rect.width} height={rect.height} />
      <LogOddsBackground width={rect.width} evidence={up} limits={limits} />
      <path class="profile-line" d={line} />
      <ZoneNames width={rect.width} evidence={up} />
      <circle class="world-stage-ladder-now" cx={x(path.length - 1)} cy={y(last)} r={5} />
      <text class="world-stage-ladder-name" x={isWide ? 44 : rect.width} y={-6} text-anchor={isWide ? "start" : "end"}>
        {isWide && (scene.ladder ? "visited cell: " : "marked cell: ")}ℓ = {signed(last)} after {path.length - 1}{" "}
        {path.length === 2 ? "scan" : "scans"}
      </text>
    </g>
  );
}

/** The reader adds a scan after this way, metres. */
const SCAN_EVERY = 0.25;
const MOST_SCANS = 150;
/** The robot's centre keeps this far from walls, metres. */
const RADIUS = 0.2;

const robotOf = (scene: Scene, shown: Shown): Pose | null =>
  ownRobot.value ?? scene.poses[Math.max(0, Math.min(shown.count, scene.poses.length) - 1)] ?? null;

const isFree = (point: Point): boolean => distanceTo(point, [...WALLS, POLISHED, ...TABLE]) >= RADIUS;

const isInside = ([x, y]: Point): boolean => x > 0.6 && x < 11.4 && y > 0.6 && y < 7.4;

/** Move the robot to a point, if it is free, and add scans on the way. */
function moveRobot(point: Point, from: Pose): void {
  if (!isInside(point) || !isFree(point)) return;
  const driven = Math.hypot(point[0] - from[0], point[1] - from[1]);
  const yaw = driven > 0.02 ? Math.atan2(point[1] - from[1], point[0] - from[0]) : from[2];
  const pose: Pose = [point[0], point[1], yaw];
  ownRobot.value = pose;
  const last = ownPoses.peek().at(-1);
  const isFar = !last || Math.hypot(point[0] - last[0], point[1] - last[1]) >= SCAN_EVERY - 1e-9;
  if (isFar && ownPoses.peek().length < MOST_SCANS) ownPoses.value = [...ownPoses.peek(), pose];
}

/** Log-odds at the ends of the colour scale, as on the other figures of the lecture. */
const RANGE = { low: -2.5, high: 3.5 };
/** A box lower than this has the ladder beside the map, CSS pixels. */
const LOW = 380;
const GAP = 10;
/** Height of the line of text above the ladder. */
const NAME = 22;

interface WorldStageProps {
  readonly scene: ReadonlySignal<Scene>;
  /** A picture for print and slides: it neither moves nor can it be changed by a hand, and shows its scene at once. */
  readonly still?: boolean;
  readonly children?: ComponentChildren;
}

/** The one map of the lecture: the floor, the robot and its map, the history of one cell, and what the scene marks. */
export function WorldStage({ scene, still = false, children }: WorldStageProps) {
  const clip = useId();
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const size = useSize(box, 640, 560);
  const shown = useStageMap(scene, still);
  const now = scene.value;
  const hasStrip = (now.history || ownCell.value !== null) && !now.drawing;
  const view = useCamera({ ...now.view, strip: hasStrip ? 1 : 0 }, still);
  const { width, height } = size.value;
  const { map, ladder } = layout(width, height, view.value.strip);
  const at = projection(view.value, map);
  useLayoutEffect(
    () =>
      effect(() => {
        void isDark.value;
        if (canvas.current) paint(canvas.current, shown.value, scene.value, projection(view.value, map), size.value);
      }),
    [shown, scene, view, size, map.width, map.height],
  );
  const transform: StageTransform = {
    width: map.width,
    height: map.height,
    metre: at.metre,
    cell: at.metre * shown.value.map.geometry.resolution,
    x: at.x,
    y: at.y,
    world: (px, py) => [...at.world(px, py)],
  };
  // While the map of another scene is computed the picture stays, and with it what is said of it.
  const texts = useRef({ caption: "", task: "" });
  if (!texts.current.caption || shown.value.history === historyOf(planOf(now)))
    texts.current = { caption: now.caption(shown.value), task: now.task };
  const { caption, task } = texts.current;
  return (
    <div class={`world-stage${still ? " still" : ""}`}>
      <div class="world-stage-box" ref={box}>
        <canvas ref={canvas} role="img" aria-label={caption} />
        <svg width={width} height={height} viewBox={`0 0 ${width} ${height}`} role="presentation">
          <clipPath id={clip}>
            <rect x={map.left} y={map.top} width={map.width} height={map.height} />
          </clipPath>
          {ladder && <Lead at={at} scene={now} shown={shown.value} ladder={ladder} />}
          <g clip-path={`url(#${clip})`}>
            <World transform={transform} scene={now} shown={shown.value} />
            <Marks transform={transform} scene={now} shown={shown.value} />
            {now.drawing ? (
              <now.drawing transform={transform} scene={now} shown={shown.value} />
            ) : (
              <Handles transform={transform} scene={now} shown={shown.value} still={still} />
            )}
          </g>
          {ladder && <Ladder rect={ladder} scene={now} shown={shown.value} />}
        </svg>
      </div>
      <div class="world-stage-caption">
        <p>
          <Variables text={caption} />{" "}
          <span class="no-print">
            <Variables text={task} />
          </span>
        </p>
        {children}
      </div>
    </div>
  );
}

/**
 * The map with the strip of a cell's history below it, in a low box beside it; the strip is drawn once it is complete.
 * A box may have no size, as a hidden one.
 */
function layout(width: number, height: number, strip: number): { map: Rect; ladder: Rect | null } {
  if (height < LOW) {
    const across = Math.round(0.4 * width * strip);
    const left = width - across;
    return {
      map: { left: 0, top: 0, width: Math.max(0, left - GAP * strip), height },
      ladder: strip < 1 ? null : { left, top: NAME, width: across, height: height - NAME },
    };
  }
  const tall = Math.round(Math.min(200, 0.26 * height) * strip);
  return {
    map: { left: 0, top: 0, width, height: height - tall - (GAP + NAME) * strip },
    ladder: strip < 1 ? null : { left: 0, top: height - tall, width, height: tall },
  };
}

interface Picture {
  readonly isDark: boolean;
  readonly trinary: boolean;
  readonly picture: OffscreenCanvas;
  /** The colour of what was never observed. */
  readonly ground: string;
}

/** The newest picture of each map: while the view moves, the cells stay as they are. */
const pictures = new WeakMap<OccupancyGrid, Picture>();

/** A map with one pixel for a cell, in the colours of now. */
function pictureOf(map: OccupancyGrid, trinary: boolean): Picture {
  const cachedPicture = pictures.get(map);
  if (cachedPicture && cachedPicture.isDark === isDark.value && cachedPicture.trinary === trinary) return cachedPicture;
  const { rows, cols } = map.geometry;
  const colours = palette(RANGE, mapColours());
  const image = new ImageData(cols, rows);
  for (let row = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) {
      const index = row * cols + col;
      const l = map.logOdds[index] ?? 0;
      const state = l > OCCUPIED ? RANGE.high : l < FREE ? RANGE.low : 0;
      const byte = Math.round(shownByteAt(trinary ? state : l, RANGE));
      const isSeen = map.observed[index] === 1 && !(trinary && state === 0);
      const from = isSeen ? 4 * byte : 0;
      image.data.set(colours.subarray(from, from + 4), 4 * ((rows - 1 - row) * cols + col));
    }
  const picture = new OffscreenCanvas(cols, rows);
  picture.getContext("2d")?.putImageData(image, 0, 0);
  const ground = `rgb(${colours[0]} ${colours[1]} ${colours[2]})`;
  const made = { isDark: isDark.value, trinary, picture, ground };
  pictures.set(map, made);
  return made;
}

/** The part of the map that is in view, enlarged without smoothing, as a share of its box, which has this size. */
function paint(
  canvas: HTMLCanvasElement,
  shown: Shown,
  scene: Scene,
  at: Projection,
  box: { readonly width: number; readonly height: number },
): void {
  const context = canvas.getContext("2d");
  if (!context) return;
  const { rows, cols, resolution } = shown.map.geometry;
  const { picture, ground } = pictureOf(shown.map, scene.trinary);
  const ratio = Math.min(2, devicePixelRatio || 1);
  const { rect } = at;
  canvas.width = Math.round(rect.width * ratio);
  canvas.height = Math.round(rect.height * ratio);
  // On paper the box has another size than on the screen, where it was measured.
  canvas.style.width = `${(100 * rect.width) / box.width}%`;
  canvas.style.height = `${(100 * rect.height) / box.height}%`;
  context.imageSmoothingEnabled = false;
  context.scale(ratio, ratio);
  context.fillStyle = ground;
  context.fillRect(0, 0, rect.width, rect.height);
  context.translate(-rect.left, -rect.top);
  const side = resolution * at.metre;
  if (!scene.bare) context.drawImage(picture, at.x(0), at.y(rows * resolution), cols * side, rows * side);
  scene.overlay?.(context, at);
}

interface PartProps {
  readonly scene: Scene;
  readonly shown: Shown;
}

/** Lines from the selected cell to its history: while the view comes nearer they widen. */
function Lead({ at, scene, shown, ladder }: PartProps & { at: Projection; ladder: Rect }) {
  if (shown.index < 0 || scene.grid || scene.bare) return null;
  const { resolution } = shown.map.geometry;
  const [x, y] = cornerOf(scene.cell, resolution);
  const side = resolution * at.metre;
  const [left, top] = [at.x(x), at.y(y + resolution)];
  const { rect } = at;
  if (left > rect.left + rect.width || left + side < rect.left) return null;
  const d =
    ladder.left === 0
      ? `M${left} ${top + side}L${ladder.left} ${ladder.top}H${ladder.left + ladder.width}L${left + side} ${top + side}Z`
      : `M${left + side} ${top}L${ladder.left} ${ladder.top}V${ladder.top + ladder.height}L${left + side} ${top + side}Z`;
  return <path class="world-stage-lead" d={d} />;
}

const cornerOf = ([x, y]: Point, resolution: number): Point => [
  Math.floor(x / resolution) * resolution,
  Math.floor(y / resolution) * resolution,
];

const limited = (value: number, most: number): number => Math.min(most - 0.01, Math.max(0.01, value));

/** The robot, and the selected cell. */
function Handles({ transform, scene, shown, still }: PartProps & { transform: StageTransform; still: boolean }) {
  const pose = robotOf(scene, shown);
  const { resolution } = shown.map.geometry;
  const [x, y] = cornerOf(scene.cell, resolution);
  const selected = (
    <rect
      class="world-stage-selected"
      x={transform.x(x)}
      y={transform.y(y + resolution)}
      width={transform.cell}
      height={transform.cell}
    />
  );
  const robot = Math.max(8, Math.min(26, 0.22 * transform.metre));
  if (still)
    return (
      <>
        {!scene.grid && !scene.bare && selected}
        {pose && (
          <g transform={`translate(${transform.x(pose[0])} ${transform.y(pose[1])})`}>
            <RobotShape yaw={pose[2]} size={robot} />
          </g>
        )}
      </>
    );
  return (
    <>
      {!scene.grid && !scene.bare && (
        <>
          {selected}
          <DragHandle
            transform={transform}
            at={[x + resolution / 2, y + resolution / 2]}
            label="Selected cell"
            sentence="Selects the cell whose history is drawn beside the map."
            text={`${written(scene.cell[0], 2)} m, ${written(scene.cell[1], 2)} m`}
            tone="neutral"
            step={resolution}
            onMove={([px, py]) => {
              ownCell.value = [limited(px, FLOOR.width), limited(py, FLOOR.height)];
            }}
          >
            {!scene.marks.includes("values") && <path class="probe" d="M-13 0H-7M7 0H13M0 -13V-7M0 7V13" />}
          </DragHandle>
        </>
      )}
      {pose && (
        <DragHandle
          transform={transform}
          at={[pose[0], pose[1]]}
          label="Robot"
          sentence="Moves the robot; it adds a scan to the map at every quarter of a metre."
          text={`${written(pose[0], 2)} m, ${written(pose[1], 2)} m`}
          step={0.25}
          onMove={(point) => moveRobot(point, pose)}
        >
          <RobotShape yaw={pose[2]} size={robot} />
        </DragHandle>
      )}
    </>
  );
}
