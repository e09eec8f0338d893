/**
 * Gestures of a 3D view in addition to those of viser's client: a drag with Shift or the middle button moves the view,
 * and the wheel and two fingers zoom at their position.
 */

const [LEFT, MIDDLE, RIGHT] = [0, 1, 2] as const;
/** `buttons` of an event while the right button alone is pressed. */
const RIGHT_PRESSED = 2;

/**
 * Make the camera's controls treat a drag with the middle button, or with the left one and Shift, as one with the right
 * button, which moves the view as in RViz.
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
 * Make objects that are created with a property `dollyToCursor` start with it enabled. These are the camera controls of
 * viser's client (camera-controls), which has no setting for it and zooms at the centre of the picture.
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
