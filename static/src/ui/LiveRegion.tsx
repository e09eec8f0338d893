import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

/** The least time between two things said, milliseconds: a sentence wants as long to be heard. */
const PAUSE_MS = 800;

/** Words for who cannot see: a polite live region that says the newest of what comes, with pauses. */
export function LiveRegion({ text }: { readonly text: string }) {
  const said = useSignal("");
  const last = useRef({ text, at: Number.NEGATIVE_INFINITY });
  useEffect(() => {
    if (text === last.current.text) return;
    const timer = setTimeout(
      () => {
        last.current = { text, at: performance.now() };
        said.value = text;
      },
      Math.max(0, last.current.at + PAUSE_MS - performance.now()),
    );
    return () => clearTimeout(timer);
  }, [text, said]);
  return (
    <p class="visually-hidden" role="status" aria-live="polite">
      {said.value}
    </p>
  );
}
