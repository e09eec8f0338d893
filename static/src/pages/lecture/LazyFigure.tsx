import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { printing } from "../../ui/theme";
import { watchVisibility } from "../../ui/visibility";
import { figureHeight, windowWidth } from "./figureHeights";
import { enqueueIdleTask } from "./idleQueue";

/** Distance from the window at which a figure is rendered, in percent of the window's height. */
const AHEAD = "100%";

interface LazyFigureProps {
  /** Render it now, wherever it is. */
  readonly now: boolean;
  /** The section that it belongs to. */
  readonly id: string;
  readonly children: ComponentChildren;
}

/**
 * A figure that is rendered when it is near the window, when it is printed, or when the page is idle; until then its
 * height is reserved.
 */
export function LazyFigure({ now, id, children }: LazyFigureProps) {
  const box = useRef<HTMLDivElement>(null);
  const near = useSignal(now);
  const before = useRef<DOMRect | null>(null);
  const isHere = near.value || now || printing.value;
  useEffect(() => {
    const target = box.current;
    if (!target || near.peek()) return;
    const setUp = (at: DOMRect): void => {
      before.current = at;
      near.value = true;
      stop();
    };
    const unwatch = watchVisibility(
      target,
      ({ isIntersecting, boundingClientRect }) => isIntersecting && setUp(boundingClientRect),
      { rootMargin: `${AHEAD} 0px` },
    );
    // In the presentation mode the other figures are hidden and have no size.
    const callOff = enqueueIdleTask(() => target.offsetWidth > 0 && setUp(target.getBoundingClientRect()));
    const stop = (): void => {
      unwatch();
      callOff();
    };
    return stop;
  }, [near]);
  useLayoutEffect(() => {
    if (isHere) near.value = true;
    // A figure above the window must not move the visible content: most browsers ensure that themselves.
    const rect = before.current;
    if (isHere && rect && rect.bottom <= 0 && !CSS.supports("overflow-anchor", "auto"))
      scrollBy({ top: (box.current?.offsetHeight ?? rect.height) - rect.height, behavior: "instant" });
  }, [isHere, near]);
  return (
    <div
      class={isHere ? "" : "figure-awaited"}
      ref={box}
      style={{ "--reserved": `${figureHeight(id, windowWidth.value)}px` }}
    >
      {isHere && children}
    </div>
  );
}
