/** Pointer gestures on a picture: tap, drag the robot, pan, pinch, wheel. */

import { zoomOf } from "../../ui/browser/useSize";

export interface Gestures {
  /** Whether a drag that begins here drags the robot. `reach` is the tolerance in pixels. */
  grabs(x: number, y: number, reach: number): boolean;
  tap(x: number, y: number): void;
  /** A request to explain a cell: a click with Shift or Alt, or a long press. */
  explain(x: number, y: number): void;
  doubleTap(x: number, y: number): void;
  /** The robot is dragged; null when it is released. */
  dragRobot(at: readonly [x: number, y: number] | null): void;
  /** Whether a drag that begins here is a stroke of a tool. */
  draws(): boolean;
  /** A stroke so far, and whether it is done; `to` is null if it was cancelled. */
  stroke(from: readonly [x: number, y: number], to: readonly [x: number, y: number] | null, isDone: boolean): void;
  pan(dx: number, dy: number): void;
  zoom(x: number, y: number, factor: number): void;
  /** The position of the mouse or the touch; null when the mouse has left. */
  hover(at: readonly [x: number, y: number] | null): void;
}

const SLOP_MOUSE = 4;
const SLOP_TOUCH = 10;
const DOUBLE_TAP_MS = 320;
const DOUBLE_TAP_PX = 24;
const LONG_PRESS_MS = 550;

interface Contact {
  x: number;
  y: number;
}

/** WebKit's `GestureEvent`, in no standard; `scale` is relative to the beginning of the gesture. */
interface TrackpadEvent extends Event {
  readonly scale: number;
  readonly clientX: number;
  readonly clientY: number;
}

type Mode = "idle" | "pressed" | "robot" | "stroke" | "pan" | "pinch" | "longPress";

/**
 * Handle the gestures on a picture; the returned function stops it. The element has `touch-action: pan-y`: one finger
 * that moves up or down scrolls the page, unless it drags the robot; two fingers always move the picture.
 */
export function listen(element: HTMLElement, gestures: Gestures): () => void {
  const contacts = new Map<number, Contact>();
  let mode: Mode = "idle";
  let start: Contact = { x: 0, y: 0 };
  let resting: ReturnType<typeof setTimeout> | undefined;
  let lastTap = { at: Number.NEGATIVE_INFINITY, x: 0, y: 0 };

  const where = (event: { clientX: number; clientY: number }): Contact => {
    const box = element.getBoundingClientRect();
    const zoom = zoomOf(element);
    return { x: (event.clientX - box.left) / zoom, y: (event.clientY - box.top) / zoom };
  };
  const slopOf = (type: string): number => (type === "mouse" ? SLOP_MOUSE : SLOP_TOUCH);
  const reachOf = (type: string): number => (type === "mouse" ? 6 : 18);

  const down = (event: PointerEvent): void => {
    if (event.pointerType === "mouse" && event.button > 1) return;
    const at = where(event);
    contacts.set(event.pointerId, at);
    element.setPointerCapture(event.pointerId);
    if (contacts.size === 1) {
      start = at;
      const isExplain = event.shiftKey || event.altKey;
      mode = "pressed";
      if (event.button === 0 && !isExplain) {
        if (gestures.draws()) mode = "stroke";
        else if (gestures.grabs(at.x, at.y, reachOf(event.pointerType))) mode = "robot";
      }
      element.dataset.mode = mode;
      gestures.hover([at.x, at.y]);
      if (event.pointerType === "touch" && mode === "pressed") {
        resting = setTimeout(() => {
          if (mode !== "pressed") return;
          mode = "longPress";
          gestures.explain(at.x, at.y);
        }, LONG_PRESS_MS);
      }
    } else {
      clearTimeout(resting);
      if (mode === "robot") gestures.dragRobot(null);
      if (mode === "stroke") gestures.stroke([start.x, start.y], null, false);
      mode = "pinch";
    }
  };

  const move = (event: PointerEvent): void => {
    const at = where(event);
    const before = contacts.get(event.pointerId);
    if (!before) {
      if (event.pointerType === "mouse") {
        gestures.hover([at.x, at.y]);
        element.dataset.over = gestures.grabs(at.x, at.y, reachOf("mouse")) ? "robot" : "";
      }
      return;
    }
    if (mode === "pinch") pinch(event.pointerId, before, at);
    contacts.set(event.pointerId, at);
    if (mode === "pressed") {
      if (Math.hypot(at.x - start.x, at.y - start.y) < slopOf(event.pointerType)) return;
      clearTimeout(resting);
      // A finger that starts upwards or downwards scrolls the page: the browser will cancel the pointer.
      if (event.pointerType === "touch" && Math.abs(at.y - start.y) > Math.abs(at.x - start.x)) return;
      mode = "pan";
      element.dataset.mode = mode;
      gestures.pan(at.x - start.x, at.y - start.y);
      return;
    }
    if (mode === "pan") gestures.pan(at.x - before.x, at.y - before.y);
    if (mode === "robot") gestures.dragRobot([at.x, at.y]);
    if (mode === "stroke") gestures.stroke([start.x, start.y], [at.x, at.y], false);
    if (mode === "robot" || mode === "stroke") gestures.hover([at.x, at.y]);
  };

  const pinch = (id: number, before: Contact, at: Contact): void => {
    const other = [...contacts].find(([key]) => key !== id)?.[1];
    if (!other) return;
    const middle = { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 };
    gestures.pan((at.x - before.x) / 2, (at.y - before.y) / 2);
    const distance = Math.hypot(before.x - other.x, before.y - other.y);
    if (distance > 8) gestures.zoom(middle.x, middle.y, Math.hypot(at.x - other.x, at.y - other.y) / distance);
  };

  const up = (event: PointerEvent): void => {
    if (!contacts.delete(event.pointerId)) return;
    const at = where(event);
    if (mode === "robot") gestures.dragRobot(null);
    if (mode === "stroke") gestures.stroke([start.x, start.y], [at.x, at.y], true);
    const travelled = Math.hypot(at.x - start.x, at.y - start.y);
    // A swipe up or down that the browser did not take for scrolling is no tap.
    if ((mode === "pressed" && travelled < slopOf(event.pointerType)) || (mode === "robot" && travelled < SLOP_MOUSE)) {
      const isDouble =
        event.timeStamp - lastTap.at < DOUBLE_TAP_MS && Math.hypot(at.x - lastTap.x, at.y - lastTap.y) < DOUBLE_TAP_PX;
      lastTap = { at: isDouble ? Number.NEGATIVE_INFINITY : event.timeStamp, ...at };
      if (mode === "pressed" && (event.shiftKey || event.altKey)) gestures.explain(at.x, at.y);
      else if (isDouble) gestures.doubleTap(at.x, at.y);
      else if (mode === "pressed") gestures.tap(at.x, at.y);
    } else lastTap.at = Number.NEGATIVE_INFINITY; // taps with a drag between them are two
    if (contacts.size === 0) settle();
  };

  const settle = (): void => {
    clearTimeout(resting);
    mode = "idle";
    element.dataset.mode = mode;
  };

  const cancel = (event: PointerEvent): void => {
    contacts.delete(event.pointerId);
    if (mode === "robot") gestures.dragRobot(null);
    if (mode === "stroke") gestures.stroke([start.x, start.y], null, false);
    if (contacts.size === 0) settle();
  };

  // A long press would open the browser's menu.
  const menu = (event: Event): void => {
    if ((event as PointerEvent).pointerType === "touch" || mode === "longPress") event.preventDefault();
  };

  const leave = (event: PointerEvent): void => {
    if (event.pointerType === "mouse" && contacts.size === 0) gestures.hover(null);
  };

  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const at = where(event);
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
    gestures.zoom(at.x, at.y, Math.exp(-Math.max(-240, Math.min(240, pixels)) * (event.ctrlKey ? 0.01 : 0.002)));
  };

  // Two fingers on a trackpad: other browsers send them as a wheel with Ctrl, WebKit as events of its own.
  let pinched = 1;
  const trackpad = (event: Event): void => {
    event.preventDefault(); // the page would be enlarged
    const { scale, clientX, clientY } = event as TrackpadEvent;
    if (event.type === "gesturechange" && contacts.size === 0) {
      const at = where({ clientX, clientY });
      gestures.zoom(at.x, at.y, scale / pinched);
    }
    pinched = scale;
  };

  // Only a touch event's handler can prevent scrolling while a finger drags the robot.
  const touch = (event: TouchEvent): void => {
    const first = event.touches[0];
    if (!first) return;
    const at = where(first);
    if (
      event.touches.length > 1 ||
      mode === "robot" ||
      gestures.draws() ||
      gestures.grabs(at.x, at.y, reachOf("touch"))
    ) {
      event.preventDefault();
    }
  };

  const stop = new AbortController();
  const { signal } = stop;
  element.addEventListener("pointerdown", down, { signal });
  element.addEventListener("pointermove", move, { signal });
  element.addEventListener("pointerup", up, { signal });
  element.addEventListener("pointercancel", cancel, { signal });
  element.addEventListener("pointerleave", leave, { signal });
  element.addEventListener("contextmenu", menu, { signal });
  element.addEventListener("wheel", wheel, { passive: false, signal });
  element.addEventListener("gesturestart", trackpad, { signal });
  element.addEventListener("gesturechange", trackpad, { signal });
  element.addEventListener("touchstart", touch, { passive: false, signal });
  element.addEventListener("touchmove", touch, { passive: false, signal });
  return () => {
    clearTimeout(resting);
    stop.abort();
  };
}
