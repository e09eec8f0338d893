/**
 * Gestures that a 3D view has beside those of viser's client: with Shift or the middle button a drag moves the view, and
 * the wheel and two fingers zoom at where they are.
 */

const [LEFT, MIDDLE, RIGHT] = [0, 1, 2] as const;
/** `buttons` of an event while the right button alone is pressed. */
const RIGHT_PRESSED = 2;

/**
 * Have the camera's controls take a drag with the middle button, or with the left one and Shift, for one with the right
 * button, which moves the view: as in RViz.
 */
export function addGestures(target: EventTarget): void {
  let moves = false;
  const pretend = (event: Event, values: Readonly<Partial<Record<"button" | "buttons", number>>>): void => {
    for (const [name, value] of Object.entries(values)) Object.defineProperty(event, name, { value });
  };
  const listen = (type: string, listener: (event: PointerEvent) => void): void =>
    target.addEventListener(type, (event) => listener(event as PointerEvent), true);
  listen("pointerdown", (event) => {
    const { pointerType, button, shiftKey } = event;
    moves = pointerType === "mouse" && (button === MIDDLE || (button === LEFT && shiftKey));
    if (moves) pretend(event, { button: RIGHT, buttons: RIGHT_PRESSED });
  });
  listen("pointermove", (event) => {
    if (moves) pretend(event, { buttons: RIGHT_PRESSED });
  });
  for (const type of ["pointerup", "pointercancel"]) {
    listen(type, (event) => {
      if (moves) pretend(event, { button: RIGHT });
      moves = false;
    });
  }
}

/**
 * Have the objects that are made with a property `dollyToCursor` begin with it on. Those are the controls of the camera
 * in viser's client (camera-controls), which has no setting for it and zooms at the middle of the picture.
 */
export function zoomAtCursor(prototype: object): void {
  Object.defineProperty(prototype, "dollyToCursor", {
    configurable: true,
    set(this: object) {
      const value = { value: true, writable: true, enumerable: true, configurable: true };
      Object.defineProperty(this, "dollyToCursor", value);
    },
  });
}
