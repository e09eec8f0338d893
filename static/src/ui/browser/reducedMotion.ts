import { signal } from "@preact/signals";

/** Whether reduced motion is preferred: the page then plays no animations. */
const query = matchMedia("(prefers-reduced-motion: reduce)");
export const reducedMotion = signal(query.matches);
query.addEventListener("change", () => {
  reducedMotion.value = query.matches;
});
