// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { addGestures, zoomAtCursor } from "./sceneGestures";

/** What a canvas hears of a press, a movement and a release. */
function heard(init: PointerEventInit): (readonly [type: string, button: number, buttons: number])[] {
  const frame = document.createElement("div");
  const canvas = frame.appendChild(document.createElement("canvas"));
  addGestures(frame);
  const differences: (readonly [string, number, number])[] = [];
  const types = ["pointerdown", "pointermove", "pointerup"] as const;
  for (const type of types) {
    canvas.addEventListener(type, (event) => differences.push([event.type, event.button, event.buttons]));
  }
  for (const type of types) {
    const buttons = type === "pointerup" ? 0 : (init.buttons ?? 0);
    canvas.dispatchEvent(new PointerEvent(type, { ...init, buttons, bubbles: true }));
  }
  return differences;
}

const MOUSE = { pointerType: "mouse" } as const;
const AS_RIGHT = [
  ["pointerdown", 2, 2],
  ["pointermove", expect.any(Number), 2],
  ["pointerup", 2, 0],
];

test("the middle button, and the left one with Shift, are heard as the right one", () => {
  expect(heard({ ...MOUSE, button: 1, buttons: 4 })).toEqual(AS_RIGHT);
  expect(heard({ ...MOUSE, button: 0, buttons: 1, shiftKey: true })).toEqual(AS_RIGHT);
});

test("the left button alone, the right one and fingers stay as they are", () => {
  expect(heard({ ...MOUSE, button: 0, buttons: 1 })[0]).toEqual(["pointerdown", 0, 1]);
  expect(heard({ ...MOUSE, button: 2, buttons: 2 })[0]).toEqual(["pointerdown", 2, 2]);
  expect(heard({ pointerType: "touch", button: 0, buttons: 1, shiftKey: true })[0]).toEqual(["pointerdown", 0, 1]);
});

test("controls of a camera zoom at the cursor, unless that is turned off later", () => {
  class Base {}
  class Controls extends Base {
    declare dollyToCursor: boolean;
    constructor() {
      super();
      this.dollyToCursor = false;
    }
  }
  zoomAtCursor(Base.prototype);
  const controls = new Controls();
  expect(controls.dollyToCursor).toBe(true);
  controls.dollyToCursor = false;
  expect(controls.dollyToCursor).toBe(false);
  expect("dollyToCursor" in {}).toBe(false);
});
