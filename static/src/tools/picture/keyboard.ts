/** Keyboard control of a picture: drive, move the cell cursor, zoom, fit. */

import { centreOf } from "../../grid/lattice";
import { type Size, toScreen, zoomedAt } from "../../render/view";
import type { Store } from "../../store/store";
import type { Point } from "../../wire/protocol";
import { useTool } from "../costmap/mapTool";
import { editAt } from "../editing/strokes";

/**
 * The effect of a click on a place of the world, or of Enter at the keyboard's cursor (`isKey`): the selected tool
 * edits the world there; without a tool the robot is placed there.
 */
export function act(store: Store, point: Point, isKey = false): void {
  if (useTool(store, point)) return;
  if (store.editing.tool.peek() === null) store.teleport(point);
  else editAt(store, point, isKey);
}

const FORWARD = 0.8; // m/s
const BACK = -0.5;
const TURN = 1.3; // rad/s
/** The server holds a drive command for half a second; while a key is down it is repeated well before that. */
const REPEAT_MS = 150;

const DRIVES: Readonly<Record<string, readonly [linear: number, angular: number]>> = {
  ArrowUp: [FORWARD, 0],
  KeyW: [FORWARD, 0],
  ArrowDown: [BACK, 0],
  KeyS: [BACK, 0],
  ArrowLeft: [0, TURN],
  KeyA: [0, TURN],
  ArrowRight: [0, -TURN],
  KeyD: [0, -TURN],
};

const STEPS: Readonly<Record<string, readonly [row: number, col: number]>> = {
  ArrowUp: [1, 0],
  ArrowDown: [-1, 0],
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
};

const ZOOMS: Readonly<Record<string, number>> = { "+": 1.25, "=": 1.25, "-": 0.8, "−": 0.8 };

/** The sum of the velocities of all keys that are down, within the limits. */
export function velocity(down: Iterable<string>): readonly [linear: number, angular: number] {
  let linear = 0;
  let angular = 0;
  for (const code of down) {
    const drive = DRIVES[code];
    if (!drive) continue;
    linear += drive[0];
    angular += drive[1];
  }
  return [Math.min(FORWARD, Math.max(BACK, linear)), Math.min(TURN, Math.max(-TURN, angular))];
}

/** Move the cell cursor; without a cursor it starts at the robot's cell. */
function moveCursor(store: Store, row: number, col: number, size: Size): void {
  const map = store.map.peek();
  const pose = store.frame.peek()?.pose;
  if (!map || !pose) return;
  const { geometry } = map;
  const from = store.cell.peek();
  const next = from ? { row: from.row + row, col: from.col + col } : store.cellOf([pose[0], pose[1]]);
  if (!next || next.row < 0 || next.col < 0 || next.row >= geometry.rows || next.col >= geometry.cols) return;
  const point = centreOf(geometry, next);
  store.pinned.value = point;
  const view = store.view.peek();
  if (!view) return;
  const [x, y] = toScreen(view, size, ...point);
  if (x < 0 || y < 0 || x > size.width || y > size.height) store.setView({ ...view, x: point[0], y: point[1] });
}

/** Handle the keys of a focused picture, which are first passed to `takes`. The returned function stops it. */
export function listenToKeys(
  element: HTMLElement,
  store: Store,
  size: () => Size,
  takes: (key: string) => boolean = () => false,
): () => void {
  const down = new Set<string>();
  let timer: ReturnType<typeof setInterval> | undefined;

  const drive = (): void => {
    const [linear, angular] = velocity(down);
    store.send({ type: "drive", linear, angular });
  };
  const release = (): void => {
    if (down.size === 0) return;
    down.clear();
    clearInterval(timer);
    drive();
  };

  const keydown = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const pinned = store.pinned.peek();
    const drives = store.isDriven.peek() && !event.shiftKey && event.code in DRIVES;
    const step = STEPS[event.key];
    const zoom = ZOOMS[event.key];
    const view = store.view.peek();
    if (takes(event.key)) {
      event.preventDefault();
      return;
    }
    if (drives) {
      if (!down.has(event.code)) {
        down.add(event.code);
        drive();
        clearInterval(timer);
        timer = setInterval(drive, REPEAT_MS);
      }
    } else if (step) moveCursor(store, step[0], step[1], size());
    else if (zoom !== undefined && view) {
      const { width, height } = size();
      store.setView(zoomedAt(view, size(), width / 2, height / 2, zoom));
    } else if (event.key === "0" || event.key === "Home") store.viewHeld.value = false;
    else if (event.key === "?") store.explain(store.probe.peek());
    else if (event.key === "Escape" && pinned && !store.explainedPoint.peek() && store.editing.tool.peek() === null)
      store.pinned.value = null;
    else if (event.key === "Enter" && store.isDriven.peek() && pinned) act(store, pinned, true);
    else if (event.key === "Escape" && store.editing.tool.peek() !== null) store.editing.take(null);
    else if (event.key === " ") store.togglePlaying();
    else return;
    event.preventDefault();
  };
  const keyup = (event: KeyboardEvent): void => {
    if (!down.delete(event.code)) return;
    if (down.size === 0) clearInterval(timer);
    drive();
  };

  const stop = new AbortController();
  element.addEventListener("keydown", keydown, { signal: stop.signal });
  element.addEventListener("keyup", keyup, { signal: stop.signal });
  element.addEventListener("blur", release, { signal: stop.signal });
  return () => {
    release();
    stop.abort();
  };
}
