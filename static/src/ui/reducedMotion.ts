import { signal } from "@preact/signals";

/** Whether the person asked for less motion: nothing then glows, fades or ripples. */
const query = matchMedia("(prefers-reduced-motion: reduce)");
export const reducedMotion = signal(query.matches);
query.addEventListener("change", () => {
  reducedMotion.value = query.matches;
});
