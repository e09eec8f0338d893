import { useEffect, useRef } from "preact/hooks";
import { later } from "../../../lessons/stage/later";
import { fitsFigures } from "./scale";
import { stage } from "./state";

/** Minimum width of a figure as a fraction of the available width. */
const NARROWEST = 0.5;

/** Maximum enlargement of a figure with its text, and of the controls beside a picture; the step of both. */
const LARGEST = 1.6;
const LARGEST_CONTROLS = 1.6;
const STEP = 0.05;
/** Controls are enlarged by a quarter, and more only while they are laid out at this width, CSS pixels. */
const ALWAYS = 1.25;
const CONTROLS_WIDTH = 380;

const heightOf = (element: Element): number => element.getBoundingClientRect().height;

/** Enlarge an element as far as it fits. Returns whether it fits without enlargement. */
function enlarge(most: number, fits: () => boolean, set: (zoom: number) => void): boolean {
  for (let zoom = most; zoom > 1; zoom -= STEP) {
    set(zoom);
    if (fits()) return true;
  }
  set(1);
  return fits();
}

/**
 * Sets the figure of a slide to the greatest width at which its height fits. A figure that is lower than the available
 * height is enlarged with its text, and so are the controls beside a picture that is higher than they are.
 */
export function useFittedFigure(on: boolean) {
  const now = on ? stage.value : null; // the figure may show more at a later step
  const hasCode = later.value !== null; // of figures that load after the first ones
  const frame = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = frame.current;
    const room = element?.parentElement;
    if (!element || !room || !on || !fitsFigures()) return;
    const controls = element.querySelector<HTMLElement>(".on-stage-controls");
    // Content that is even slightly too high scrolls. The scroll bar would make the area narrower, and with it the
    // figure, so that it would fit again.
    const fits = (): boolean => room.scrollHeight <= room.clientHeight && heightOf(element) <= heightOf(room) + 0.5;
    const resize = (): void => {
      const widest = room.clientWidth - 1; // it is rounded, and so are enlarged widths: the border must not be cut
      const setZoom = (zoom: number): void => {
        element.style.zoom = String(zoom);
        element.style.width = `${widest / zoom}px`;
      };
      // The drawing of the stage depends on its size, so the stage is not enlarged.
      if (enlarge(controls ? 1 : LARGEST, fits, setZoom)) return;
      for (let width = 0.98 * widest; width > NARROWEST * widest; width *= 0.98) {
        element.style.width = `${width}px`;
        if (fits()) return;
      }
      element.style.width = `${widest}px`; // it scrolls within the slide
    };
    const settle = (): void => {
      if (controls) controls.style.zoom = "";
      resize();
      if (!controls) return;
      const before = heightOf(element);
      const staysAsHigh = (): boolean => heightOf(element) <= before + 0.5;
      const most = Math.max(ALWAYS, Math.min(LARGEST_CONTROLS, controls.clientWidth / CONTROLS_WIDTH));
      enlarge(most, staysAsHigh, (zoom) => {
        controls.style.zoom = String(zoom);
      });
    };
    const observer = new ResizeObserver(settle);
    observer.observe(room);
    // Its content may grow later, for example by a sentence that needs another line. It is not enlarged again, so that
    // nothing changes its size while a handle is dragged.
    const growth = new ResizeObserver(() => fits() || settle());
    growth.observe(element);
    let isOver = false;
    void document.fonts.ready.then(() => isOver || settle());
    return () => {
      isOver = true;
      observer.disconnect();
      growth.disconnect();
      element.style.width = "";
      element.style.zoom = "";
      if (controls) controls.style.zoom = "";
    };
  }, [on, now, hasCode]);
  return frame;
}
