/** The border between two parts of the box around it that has `data-split`, which is dragged or moved by keys. */

import { useRef } from "preact/hooks";
import "./splitter.css";

interface Limits {
  readonly low: number;
  readonly high: number;
}

const STEP = 0.02;
const FAR = 0.1;

export const limited = (share: number, { low, high }: Limits): number => Math.min(high, Math.max(low, share));

/** The share after a key; null for a key that means nothing here. */
export function keyedShare(key: string, now: number, limits: Limits): number | null {
  const by = (amount: number): number => limited(Math.round((now + amount) * 100) / 100, limits);
  switch (key) {
    case "ArrowRight":
    case "ArrowDown":
      return by(STEP);
    case "ArrowLeft":
    case "ArrowUp":
      return by(-STEP);
    case "PageDown":
      return by(FAR);
    case "PageUp":
      return by(-FAR);
    case "Home":
      return limits.low;
    case "End":
      return limits.high;
    default:
      return null;
  }
}

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
