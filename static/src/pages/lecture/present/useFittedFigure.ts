import { useEffect, useRef } from "preact/hooks";
import { stage } from "./state";

/** Least width of a figure as a fraction of the available width. */
const NARROWEST = 0.5;

/** Sets the figure of a slide to the greatest width at which its height fits. */
export function useFittedWidth(on: boolean) {
  const now = on ? stage.value : null; // the figure may show more of itself at a later step
  const frame = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = frame.current;
    const room = element?.parentElement;
    if (!element || !room || !on) return;
    const settle = (): void => {
      const widest = room.clientWidth;
      for (let width = widest; width > NARROWEST * widest; width *= 0.98) {
        element.style.width = `${width}px`;
        if (element.offsetHeight <= room.clientHeight) return;
      }
      element.style.width = `${widest}px`; // it scrolls within the slide
    };
    const observer = new ResizeObserver(settle);
    observer.observe(room);
    return () => {
      observer.disconnect();
      element.style.width = "";
    };
  }, [on, now]);
  return frame;
}
