// @vitest-environment happy-dom
import { beforeEach, expect, test, vi } from "vitest";
import { type Gestures, listen } from "./gestures";

let element: HTMLElement;
let calls: unknown[][];
let drawing: boolean;

beforeEach(() => {
  element = document.createElement("div");
  element.setPointerCapture = () => undefined;
  calls = [];
  drawing = false;
  const record =
    (name: string) =>
    (...parameters: unknown[]): void =>
      void calls.push([name, ...parameters]);
  const gestures: Gestures = {
    grabs: (x, y) => Math.hypot(x - 100, y - 100) < 10,
    tap: record("tap"),
    explain: record("explain"),
    doubleTap: record("doubleTap"),
    dragRobot: record("dragRobot"),
    draws: () => drawing,
    stroke: record("stroke"),
    pan: record("pan"),
    zoom: record("zoom"),
    hover: () => undefined,
  };
  listen(element, gestures);
});

let clock = 0;
function point(type: string, x: number, y: number, more: Partial<PointerEventInit> = {}): void {
  const event = new PointerEvent(type, {
    clientX: x,
    clientY: y,
    pointerId: 1,
    pointerType: "mouse",
    button: 0,
    ...more,
  });
  clock += 1000;
  Object.defineProperty(event, "timeStamp", { value: clock });
  element.dispatchEvent(event);
}

test("press and release in place is a tap", () => {
  point("pointerdown", 20, 30);
  point("pointermove", 22, 31);
  point("pointerup", 22, 31);
  expect(calls).toEqual([["tap", 22, 31]]);
});

test("two quick taps in one place are one and a double tap", () => {
  point("pointerdown", 20, 30);
  point("pointerup", 20, 30);
  clock -= 1900;
  point("pointerdown", 20, 30);
  point("pointerup", 20, 30);
  expect(calls).toEqual([
    ["tap", 20, 30],
    ["doubleTap", 20, 30],
  ]);
});

test("two quick taps with a drag between them are two taps", () => {
  point("pointerdown", 20, 30);
  point("pointerup", 20, 30);
  const first = clock;
  point("pointerdown", 20, 30);
  point("pointermove", 60, 30);
  point("pointerup", 60, 30);
  clock = first - 1900;
  point("pointerdown", 20, 30);
  point("pointerup", 20, 30);
  expect(calls.map(([name]) => name)).toEqual(["tap", "pan", "tap"]);
});

test("a drag of empty space pans by all of its way and taps nothing", () => {
  point("pointerdown", 20, 30);
  point("pointermove", 30, 30);
  point("pointermove", 35, 37);
  point("pointerup", 35, 37);
  expect(calls).toEqual([
    ["pan", 10, 0],
    ["pan", 5, 7],
  ]);
});

test("a drag that begins on the robot drags it and releases it at the end", () => {
  point("pointerdown", 104, 100);
  point("pointermove", 150, 120);
  point("pointerup", 150, 120);
  expect(calls).toEqual([
    ["dragRobot", [150, 120]],
    ["dragRobot", null],
  ]);
});

test("a second finger turns everything into a pinch about the middle", () => {
  const finger = (id: number): Partial<PointerEventInit> => ({ pointerId: id, pointerType: "touch" });
  point("pointerdown", 100, 100, finger(1));
  point("pointerdown", 200, 100, finger(2));
  point("pointermove", 300, 100, finger(2));
  expect(calls).toEqual([
    ["dragRobot", null],
    ["pan", 50, 0],
    ["zoom", 200, 100, 2],
  ]);
  point("pointerup", 300, 100, finger(2));
  point("pointerup", 100, 100, finger(1));
  expect(calls.length).toBe(3);
});

test("a cancelled touch is no tap", () => {
  point("pointerdown", 20, 30, { pointerType: "touch" });
  point("pointercancel", 20, 30, { pointerType: "touch" });
  expect(calls).toEqual([]);
});

test("a finger that starts upwards does not pan; one that starts sideways does", () => {
  point("pointerdown", 20, 80, { pointerType: "touch" });
  point("pointermove", 22, 50, { pointerType: "touch" });
  point("pointercancel", 22, 50, { pointerType: "touch" });
  expect(calls).toEqual([]);
  point("pointerdown", 20, 80, { pointerType: "touch" });
  point("pointermove", 50, 78, { pointerType: "touch" });
  expect(calls).toEqual([["pan", 30, -2]]);
});

test("a click with Shift or Alt requests an explanation and does not drag the robot", () => {
  for (const key of [{ shiftKey: true }, { altKey: true }]) {
    calls = [];
    point("pointerdown", 100, 100, key);
    point("pointerup", 100, 100, key);
    expect(calls).toEqual([["explain", 100, 100]]);
  }
});

test("a long press requests an explanation once; a moved or lifted finger does not", () => {
  vi.useFakeTimers();
  const finger = { pointerType: "touch" };
  point("pointerdown", 20, 30, finger);
  vi.advanceTimersByTime(1000);
  point("pointerup", 20, 30, finger);
  expect(calls).toEqual([["explain", 20, 30]]);
  calls = [];
  point("pointerdown", 20, 30, finger);
  point("pointermove", 60, 30, finger);
  vi.advanceTimersByTime(1000);
  point("pointerup", 60, 30, finger);
  point("pointerdown", 20, 30, finger);
  vi.advanceTimersByTime(100);
  point("pointerup", 20, 30, finger);
  vi.advanceTimersByTime(1000);
  expect(calls.map(([name]) => name)).toEqual(["pan", "tap"]);
  vi.useRealTimers();
});

test("with a selected tool a drag is a stroke, wherever it begins", () => {
  drawing = true;
  point("pointerdown", 100, 100);
  point("pointermove", 130, 140);
  point("pointerup", 150, 160);
  expect(calls).toEqual([
    ["stroke", [100, 100], [130, 140], false],
    ["stroke", [100, 100], [150, 160], true],
  ]);
});

test("a stroke is cancelled by the browser's pointercancel and by a second finger", () => {
  drawing = true;
  point("pointerdown", 20, 20);
  point("pointercancel", 20, 20);
  expect(calls).toEqual([["stroke", [20, 20], null, false]]);
  calls = [];
  point("pointerdown", 20, 20, { pointerType: "touch" });
  point("pointerdown", 60, 20, { pointerType: "touch", pointerId: 2 });
  expect(calls).toEqual([["stroke", [20, 20], null, false]]);
});

test("a pinch on a trackpad in WebKit zooms by steps of its scale, and fingers on a screen do so themselves", () => {
  const pinch = (type: string, scale: number): boolean =>
    element.dispatchEvent(Object.assign(new Event(type, { cancelable: true }), { scale, clientX: 30, clientY: 40 }));
  expect(pinch("gesturestart", 1)).toBe(false); // the page is not enlarged
  pinch("gesturechange", 2);
  pinch("gesturechange", 3);
  pinch("gesturestart", 1);
  pinch("gesturechange", 0.5);
  expect(calls).toEqual([
    ["zoom", 30, 40, 2],
    ["zoom", 30, 40, 1.5],
    ["zoom", 30, 40, 0.5],
  ]);
  calls = [];
  point("pointerdown", 20, 30, { pointerType: "touch" });
  pinch("gesturestart", 1);
  pinch("gesturechange", 2);
  expect(calls).toEqual([]);
});
