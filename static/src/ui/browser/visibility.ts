/**
 * Observe the visibility of an element; the returned function stops it. A busy browser reports several changes at once,
 * the oldest first: only the newest is passed on.
 */
export function watchVisibility(
  target: Element,
  onChange: (now: IntersectionObserverEntry) => void,
  options?: IntersectionObserverInit,
): () => void {
  const observer = new IntersectionObserver((entries) => {
    const newest = entries.at(-1);
    if (newest) onChange(newest);
  }, options);
  observer.observe(target);
  return () => observer.disconnect();
}
