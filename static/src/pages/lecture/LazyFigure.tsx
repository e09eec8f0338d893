import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { printing } from "../../ui/browser/theme";
import { awaitFigure } from "./awaitedFigures";

interface LazyFigureProps {
  /** Render it now, wherever it is. */
  readonly now: boolean;
  readonly children: ComponentChildren;
}

/** A figure that is rendered when it is near the window, when it is printed, or when the page is idle. */
export function LazyFigure({ now, children }: LazyFigureProps) {
  const box = useRef<HTMLDivElement>(null);
  const near = useSignal(now);
  const isHere = near.value || now || printing.value;
  useLayoutEffect(() => {
    if (isHere) near.value = true;
    if (isHere || !box.current) return;
    return awaitFigure(box.current, () => {
      near.value = true;
    });
  }, [isHere, near]);
  return (
    <div class={isHere ? "" : "figure-awaited"} ref={box}>
      {isHere && children}
    </div>
  );
}
