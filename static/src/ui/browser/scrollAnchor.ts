/** Scroll anchoring for browsers that have none (WebKit): what is in view stays where it is while the page fills. */

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

/**
 * Keep the first of the `blocks` of `content` that begins in the window, below its scroll padding, where it is when
 * `content` changes its height. The returned function ends it. Does nothing where the browser does the same, see CSS
 * Scroll Anchoring Level 1.
 */
export function anchorScroll(content: Element, blocks: string): () => void {
  if (CSS.supports("overflow-anchor", "auto")) return () => {};
  let anchor: Element | undefined;
  let [top, scrolled] = [0, 0]; // of the anchor, and of the page, when they were looked for
  const topOf = (block: Element | undefined): number => block?.getBoundingClientRect().top ?? 0;
  const look = (): void => {
    const padding = Number.parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0; // or "auto"
    anchor = [...content.querySelectorAll(blocks)].find((block) => topOf(block) > padding - 1);
    [top, scrolled] = [topOf(anchor), scrollY];
  };
  // Called after the layout and before the frame is painted.
  const observer = new ResizeObserver(() => {
    if (scrollY === 0 || !anchor?.isConnected) return look();
    scrollBy({ top: topOf(anchor) - top, behavior: "instant" }); // rounded: `top` stays, so that errors do not add up
    scrolled = scrollY;
  });
  observer.observe(content);
  const stop = new AbortController();
  // In the capture phase: before what renders more of the page on the same event. The event of the correction above
  // comes a frame later, when something may have moved again.
  const onScroll = (): void => {
    if (scrollY !== scrolled) look();
  };
  addEventListener("scroll", onScroll, { capture: true, passive: true, signal: stop.signal });
  return () => {
    stop.abort();
    observer.disconnect();
  };
}
