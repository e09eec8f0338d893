import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { isWriting } from "../browser/isTyping";
import { ARRANGEMENTS, arranged, type Layout, read, written } from "./layout";

/** The parameter of the page's address that names the layout. */
export const LAYOUT = "views";

export interface LayoutOptions {
  /** The kinds of views that there are. */
  readonly kinds: readonly string[];
  /** The layout where nothing else names one; the address does not name it. */
  readonly usual: Layout;
  /** The layout of the link that was followed, as text. */
  readonly linked?: string | null;
  /** The layout that this browser used last, as text; null where none is kept. */
  readonly last: Signal<string> | null;
}

/**
 * The layout of a page's views: at first that of the address, of the link, or the last one of this browser.
 * A change is kept in the address and in the browser; the keys 1 to 4 choose an arrangement.
 */
export function useLayout(options: LayoutOptions): Signal<Layout> {
  const { kinds, usual, last } = options;
  const layout = useSignal(first(options));
  const text = useSignal(written(layout.peek()));
  useSignalEffect(() => {
    const now = written(layout.value);
    if (now === text.peek()) return;
    text.value = now;
    if (last) last.value = now;
    const query = new URLSearchParams(location.search);
    if (now === written(usual)) query.delete(LAYOUT);
    else query.set(LAYOUT, now);
    history.replaceState(history.state, "", location.pathname + legible(query) + location.hash);
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

/** A query with the layout that the page's address names, if it names one. */
export function withLayout(query: URLSearchParams): string {
  const now = new URLSearchParams(location.search).get(LAYOUT);
  if (now !== null) query.set(LAYOUT, now);
  return legible(query);
}

/** A query as text, in which colons and commas are legible. */
const legible = (query: URLSearchParams): string =>
  query.size > 0 ? `?${query.toString().replaceAll("%3A", ":").replaceAll("%2C", ",")}` : "";

function first({ kinds, usual, linked, last }: LayoutOptions): Layout {
  const addressed = new URLSearchParams(location.search).get(LAYOUT);
  const texts = [addressed, linked, last?.peek()];
  for (const text of texts) {
    const parsed = text ? read(text, kinds) : null;
    if (parsed) return parsed;
  }
  return usual;
}
