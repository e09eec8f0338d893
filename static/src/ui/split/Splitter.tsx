/** The border between two parts of the box around it that has `data-split`, which is dragged or moved by keys. */

import { useRef } from "preact/hooks";
import { keyedShare, type Limits, limited } from "./share";
import "./splitter.css";

interface SplitterProps {
  readonly label: string;
  /** Id of the part before it, whose size it sets. */
  readonly controls: string;
  /** Whether its parts are beside each other ("x"), or one above the other ("y"). */
  readonly axis: "x" | "y";
  /** The share of the box that the part before it has, 0 … 1. */
  readonly share: number;
  readonly limits: Limits;
  readonly onShare: (share: number) => void;
  /** A double click, or Enter: as it was at first. */
  readonly onReset: () => void;
}

export function Splitter({ label, controls, axis, share, limits, onShare, onReset }: SplitterProps) {
  const isHeld = useRef(false);
  const drag = (event: PointerEvent): void => {
    const bar = event.currentTarget as HTMLElement;
    const box = bar.closest("[data-split]")?.getBoundingClientRect();
    if (!isHeld.current || !box) return;
    const [at, size] = axis === "x" ? [event.clientX - box.left, box.width] : [event.clientY - box.top, box.height];
    if (size > 0) onShare(limited(at / size, limits));
  };
  const release = (): void => {
    isHeld.current = false;
  };
  return (
    // biome-ignore lint/a11y/useSemanticElements: <hr> takes no focus and no value
    <div
      class={`splitter along-${axis}`}
      role="separator"
      tabIndex={0}
      aria-label={label}
      aria-controls={controls}
      aria-orientation={axis === "x" ? "vertical" : "horizontal"}
      aria-valuemin={Math.round(100 * limits.low)}
      aria-valuemax={Math.round(100 * limits.high)}
      aria-valuenow={Math.round(100 * share)}
      title={`${label}: drag it, or double-click to reset`}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.preventDefault();
        event.currentTarget.focus();
        event.currentTarget.setPointerCapture(event.pointerId);
        isHeld.current = true;
      }}
      onPointerMove={drag}
      onPointerUp={release}
      onPointerCancel={release}
      onDblClick={onReset}
      onKeyDown={(event) => {
        const next = keyedShare(event.key, share, limits);
        if (next !== null) onShare(next);
        else if (event.key === "Enter") onReset();
        else return;
        event.preventDefault();
      }}
    />
  );
}
