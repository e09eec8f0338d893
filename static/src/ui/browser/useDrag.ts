import { useRef } from "preact/hooks";
import { zoomOf } from "./useSize";

interface Drag<T> {
  /** The value of what is dragged when it is grabbed. */
  readonly begin: () => T;
  /** `dx` and `dy` are CSS pixels of the element from where it was grabbed; `fine` while Shift is held. */
  readonly move: (from: T, dx: number, dy: number, fine: boolean) => void;
  /** Called once, when it is let go. */
  readonly end?: (() => void) | undefined;
}

type Pointed = PointerEvent & { readonly currentTarget: HTMLElement | SVGElement };

/** The pointer events of an element that is dragged with the main button, a pen or a finger, and takes the focus. */
export function useDrag<T>({ begin, move, end }: Drag<T>) {
  const start = useRef<{ readonly x: number; readonly y: number; readonly from: T } | null>(null);
  const release = (): void => {
    if (start.current) end?.();
    start.current = null;
  };
  return {
    onPointerDown: (event: Pointed): void => {
      if (event.button !== 0) return;
      event.preventDefault();
      event.currentTarget.focus({ preventScroll: true });
      event.currentTarget.setPointerCapture(event.pointerId);
      start.current = { x: event.clientX, y: event.clientY, from: begin() };
    },
    onPointerMove: (event: Pointed): void => {
      if (!start.current) return;
      const { x, y, from } = start.current;
      const zoom = zoomOf(event.currentTarget);
      move(from, (event.clientX - x) / zoom, (event.clientY - y) / zoom, event.shiftKey);
    },
    onPointerUp: release,
    onPointerCancel: release,
    onLostPointerCapture: release,
  };
}
