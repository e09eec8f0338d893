import { whenIdle } from "../../ui/browser/whenIdle";

/** Milliseconds without input before a slice of the work is done, and those that it may take. */
const WAIT_MS = 16;
const SLICE_MS = 12;

/**
 * Do long work in slices while the page has no input, or all of it at once, as for paper. `piece` does one piece and
 * returns whether there are more; `show` is called after each slice. The returned function stops the work.
 */
export function inSlices(atOnce: boolean, piece: () => boolean, show: () => void): () => void {
  let stop = (): void => undefined;
  const slice = (): void => {
    const end = atOnce ? Number.POSITIVE_INFINITY : performance.now() + SLICE_MS;
    let isMore = true;
    while (isMore && performance.now() < end) isMore = piece();
    show();
    if (isMore) stop = whenIdle(WAIT_MS, slice);
  };
  if (atOnce) slice();
  else stop = whenIdle(WAIT_MS, slice);
  return () => stop();
}
