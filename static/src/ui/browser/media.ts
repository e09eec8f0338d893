import { type ReadonlySignal, signal, useSignal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";

/** Whether reduced motion is preferred: the page then plays no animations. */
const query = matchMedia("(prefers-reduced-motion: reduce)");
export const reducedMotion = signal(query.matches);
query.addEventListener("change", () => {
  reducedMotion.value = query.matches;
});

/** Whether this device is used by touch. */
export const isTouched = (): boolean => matchMedia("(pointer: coarse)").matches;

/** What a hint says on this device: "Click" is "Tap" where it is used by touch. */
export const inHand = (hint: string): string =>
  isTouched() ? hint.replace(/\bClick\b/g, "Tap").replace(/\bclick\b/g, "tap") : hint;

/** Whether a media query holds, as it changes. */
export function useMedia(query: string): ReadonlySignal<boolean> {
  const holds = useSignal(matchMedia(query).matches);
  useLayoutEffect(() => {
    const list = matchMedia(query);
    const take = (): void => {
      holds.value = list.matches;
    };
    take();
    list.addEventListener("change", take);
    return () => list.removeEventListener("change", take);
  }, [query]);
  return holds;
}
