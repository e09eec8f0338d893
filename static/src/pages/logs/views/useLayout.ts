import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { kept } from "../../../ui/browser/kept";
import { ARRANGEMENTS, arranged, type Layout, layoutOf, read, written } from "../../../ui/stage/layout";
import { isWriting } from "../isTyping";

/** The parameter of the page's address that names the layout. */
export const LAYOUT = "views";

/** The layout that this browser used last, as text. */
const last = kept("gridbloom.logs.views", "", (value): value is string => typeof value === "string");

export const MAP_ALONE: Layout = layoutOf("one", ["map"]);

/**
 * The layout of a log's views: at first that of the address, of the link (`linked`), or the last one of this browser.
 * A change is kept in the address and in the browser; the keys 1 to 4 choose an arrangement.
 */
export function useLayout(kinds: readonly string[], linked: string | null, isGuest: boolean): Signal<Layout> {
  const layout = useSignal(first(kinds, linked, isGuest));
  const text = useSignal(written(layout.peek()));
  useSignalEffect(() => {
    const now = written(layout.value);
    if (now === text.peek()) return;
    text.value = now;
    if (!isGuest) last.value = now;
    const query = new URLSearchParams(location.search);
    if (now === written(MAP_ALONE)) query.delete(LAYOUT);
    else query.set(LAYOUT, now);
    // Colons and commas are legible in an address.
    const search = query.size > 0 ? `?${query.toString().replaceAll("%3A", ":").replaceAll("%2C", ",")}` : "";
    history.replaceState(history.state, "", location.pathname + search + location.hash);
  });
  useSignalEffect(() => {
    const onKey = (event: KeyboardEvent): void => {
      const arrangement = ARRANGEMENTS[Number(event.key) - 1];
      if (!arrangement || event.ctrlKey || event.metaKey || event.altKey || isWriting(event.target)) return;
      layout.value = arranged(layout.peek(), arrangement, kinds);
    };
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  });
  return layout;
}

function first(kinds: readonly string[], linked: string | null, isGuest: boolean): Layout {
  const addressed = new URLSearchParams(location.search).get(LAYOUT);
  const texts = [addressed, linked, isGuest ? null : last.peek()];
  for (const text of texts) {
    const found = text ? read(text, kinds) : null;
    if (found) return found;
  }
  return MAP_ALONE;
}
