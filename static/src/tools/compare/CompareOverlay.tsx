/** Overlay on the picture of two maps: the names of the maps and the divider between them. */

import { useId, useRef } from "preact/hooks";
import type { Comparison } from "./comparison";
import "./compare.css";

interface CompareOverlayProps {
  readonly comparison: Comparison;
  /** Short labels of A and B. */
  readonly names: { readonly a: string; readonly b: string };
  /** Why difference and sum cannot be computed; null if they can. */
  readonly refused: string | null;
}

export function CompareOverlay({ comparison, names, refused }: CompareOverlayProps) {
  if (!comparison.isOn.value) return null;
  const mode = comparison.mode.value;
  const side = (which: "a" | "b") => (
    <span class={`compare-name compare-name-${which}`} data-side={which}>
      <b>{which.toUpperCase()}</b> {names[which]}
    </span>
  );
  if (comparison.isApart.value) return side("b");
  if (mode === "swipe") {
    return (
      <>
        {side("a")}
        {side("b")}
        <Divider comparison={comparison} />
      </>
    );
  }
  if (mode === "blink") return side(comparison.shown.value);
  const why = refused ?? (mode === "merge" ? comparison.noMerge.value : null);
  return why === null ? (
    <span class="compare-name compare-name-a" data-side={mode}>
      <b>{mode === "merge" ? "A + B" : "B − A"}</b>
    </span>
  ) : (
    <p class="compare-refused">{why} Swipe and blink can still show both maps.</p>
  );
}

const KEYS: Readonly<Record<string, number>> = {
  ArrowLeft: -0.02,
  ArrowDown: -0.02,
  ArrowRight: 0.02,
  ArrowUp: 0.02,
  PageDown: -0.1,
  PageUp: 0.1,
  Home: -1,
  End: 1,
};

const inside = (at: number): number => Math.min(1, Math.max(0, at));

function Divider({ comparison }: { readonly comparison: Comparison }) {
  const line = useRef<HTMLDivElement>(null);
  const id = useId();
  const { divider } = comparison;
  const percent = Math.round(100 * divider.value);
  const drag = (event: PointerEvent): void => {
    const box = line.current?.parentElement?.getBoundingClientRect();
    if (box && box.width > 0) divider.value = inside((event.clientX - box.left) / box.width);
  };
  return (
    <div
      ref={line}
      class="compare-divider"
      style={{ left: `${100 * divider.value}%` }}
      role="slider"
      tabIndex={0}
      aria-label="Divider between A, on the left, and B"
      aria-describedby={id}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={percent}
      aria-valuetext={`A ${percent} %, B ${100 - percent} %`}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.stopPropagation();
        event.currentTarget.setPointerCapture(event.pointerId);
      }}
      onPointerMove={(event) => {
        event.stopPropagation();
        if (event.currentTarget.hasPointerCapture(event.pointerId)) drag(event);
      }}
      onDblClick={() => {
        divider.value = 0.5;
      }}
      onKeyDown={(event) => {
        const step = KEYS[event.key];
        if (step === undefined) return;
        event.preventDefault();
        divider.value = inside(divider.peek() + step);
      }}
    >
      <span class="compare-grip" aria-hidden="true" />
      <span id={id} hidden>
        The picture shows A to the left of the divider and B to the right.
      </span>
    </div>
  );
}
