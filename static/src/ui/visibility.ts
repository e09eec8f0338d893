/**
 * Hear of how an element comes into sight and goes out of it; the result stops it. A browser that is busy tells of several
 * changes at once, the oldest first: only the newest says how it is now.
 */
export function watchVisibility(
  target: Element,
  told: (now: IntersectionObserverEntry) => void,
  options?: IntersectionObserverInit,
): () => void {
  const observer = new IntersectionObserver((entries) => {
    const newest = entries.at(-1);
    if (newest) told(newest);
  }, options);
  observer.observe(target);
  return () => observer.disconnect();
}
