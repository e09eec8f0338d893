import { beforeEach, expect, test, vi } from "vitest";
import { type Gestures, listen } from "./gestures";

let element: HTMLElement;
let told: unknown[][];
let drawing: boolean;

beforeEach(() => {
  element = document.createElement("div");
  element.setPointerCapture = () => undefined;
  told = [];
  drawing = false;
  const tell =
    (name: string) =>
    (...words: unknown[]): void =>
      void told.push([name, ...words]);
  const gestures: Gestures = {
    grabs: (x, y) => Math.hypot(x - 100, y - 100) < 10,
    tap: tell("tap"),
    ask: tell("ask"),
    doubleTap: tell("doubleTap"),
    carry: tell("carry"),
    draws: () => drawing,
    stroke: tell("stroke"),
    pan: tell("pan"),
    zoom: tell("zoom"),
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
  expect(told).toEqual([["tap", 22, 31]]);
});

test("two quick taps in one place are one and a double tap", () => {
  point("pointerdown", 20, 30);
  point("pointerup", 20, 30);
  clock -= 1900;
  point("pointerdown", 20, 30);
  point("pointerup", 20, 30);
  expect(told.map(([name]) => name)).toEqual(["tap", "doubleTap"]);
});

test("a drag of empty space pans by all of its way and taps nothing", () => {
  point("pointerdown", 20, 30);
  point("pointermove", 30, 30);
  point("pointermove", 35, 37);
  point("pointerup", 35, 37);
  expect(told).toEqual([
    ["pan", 10, 0],
    ["pan", 5, 7],
  ]);
});

test("a drag that begins on the robot carries it and then lets go", () => {
  point("pointerdown", 104, 100);
  point("pointermove", 150, 120);
  point("pointerup", 150, 120);
  expect(told).toEqual([
    ["carry", [150, 120]],
    ["carry", null],
  ]);
});

test("a second finger turns everything into a pinch about the middle", () => {
  const finger = (id: number): Partial<PointerEventInit> => ({ pointerId: id, pointerType: "touch" });
  point("pointerdown", 100, 100, finger(1));
  point("pointerdown", 200, 100, finger(2));
  point("pointermove", 300, 100, finger(2));
  expect(told).toEqual([
    ["carry", null],
    ["pan", 50, 0],
    ["zoom", 200, 100, 2],
  ]);
  point("pointerup", 300, 100, finger(2));
  point("pointerup", 100, 100, finger(1));
  expect(told.length).toBe(3);
});

test("a cancelled touch is no tap", () => {
  point("pointerdown", 20, 30, { pointerType: "touch" });
  point("pointercancel", 20, 30, { pointerType: "touch" });
  expect(told).toEqual([]);
});

test("a finger that sets out upwards leaves the view alone; one that sets out sideways pans", () => {
  point("pointerdown", 20, 80, { pointerType: "touch" });
  point("pointermove", 22, 50, { pointerType: "touch" });
  point("pointercancel", 22, 50, { pointerType: "touch" });
  expect(told).toEqual([]);
  point("pointerdown", 20, 80, { pointerType: "touch" });
  point("pointermove", 50, 78, { pointerType: "touch" });
  expect(told).toEqual([["pan", 30, -2]]);
});

test("a click with Shift or Alt asks, and takes no robot along", () => {
  for (const key of [{ shiftKey: true }, { altKey: true }]) {
    told = [];
    point("pointerdown", 100, 100, key);
    point("pointerup", 100, 100, key);
    expect(told).toEqual([["ask", 100, 100]]);
  }
});

test("a finger that rests asks once; one that moves on or lifts does not", () => {
  vi.useFakeTimers();
  const finger = { pointerType: "touch" };
  point("pointerdown", 20, 30, finger);
  vi.advanceTimersByTime(1000);
  point("pointerup", 20, 30, finger);
  expect(told).toEqual([["ask", 20, 30]]);
  told = [];
  point("pointerdown", 20, 30, finger);
  point("pointermove", 60, 30, finger);
  vi.advanceTimersByTime(1000);
  point("pointerup", 60, 30, finger);
  point("pointerdown", 20, 30, finger);
  vi.advanceTimersByTime(100);
  point("pointerup", 20, 30, finger);
  vi.advanceTimersByTime(1000);
  expect(told.map(([name]) => name)).toEqual(["pan", "tap"]);
  vi.useRealTimers();
});

test("with a tool in the hand a drag is a stroke, wherever it begins", () => {
  drawing = true;
  point("pointerdown", 100, 100);
  point("pointermove", 130, 140);
  point("pointerup", 150, 160);
  expect(told).toEqual([
    ["stroke", [100, 100], [130, 140], false],
    ["stroke", [100, 100], [150, 160], true],
  ]);
});

test("a stroke that the browser takes away is broken off, and so is one that a second finger joins", () => {
  drawing = true;
  point("pointerdown", 20, 20);
  point("pointercancel", 20, 20);
  expect(told).toEqual([["stroke", [20, 20], null, false]]);
  told = [];
  point("pointerdown", 20, 20, { pointerType: "touch" });
  point("pointerdown", 60, 20, { pointerType: "touch", pointerId: 2 });
  expect(told).toEqual([["stroke", [20, 20], null, false]]);
});
