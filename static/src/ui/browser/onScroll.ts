/** Call `look` in the next frame, and in that after each scrolling or resizing; return how to end it. */
export function onScroll(look: () => void): () => void {
  let frame = 0;
  const later = (): void => {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      look();
    });
  };
  later();
  const stop = new AbortController();
  addEventListener("scroll", later, { passive: true, signal: stop.signal });
  addEventListener("resize", later, { passive: true, signal: stop.signal });
  return () => {
    stop.abort();
    cancelAnimationFrame(frame);
  };
}
