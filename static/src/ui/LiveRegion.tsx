import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

/** Least time between two announcements, so that one can be heard before the next. */
const PAUSE_MS = 800;

/** A polite live region for screen readers that announces the newest text, with pauses. */
export function LiveRegion({ text }: { readonly text: string }) {
  const announced = useSignal("");
  const last = useRef({ text, at: Number.NEGATIVE_INFINITY });
  useEffect(() => {
    if (text === last.current.text) return;
    const timer = setTimeout(
      () => {
        last.current = { text, at: performance.now() };
        announced.value = text;
      },
      Math.max(0, last.current.at + PAUSE_MS - performance.now()),
    );
    return () => clearTimeout(timer);
  }, [text, announced]);
  return (
    <p class="visually-hidden" role="status" aria-live="polite">
      {announced.value}
    </p>
  );
}
