/** How views share a stage: one, two beside or above each other, or a grid of four, with the borders between them. */

export const ARRANGEMENTS = ["one", "beside", "above", "four"] as const;
export type Arrangement = (typeof ARRANGEMENTS)[number];

export interface Layout {
  readonly arrangement: Arrangement;
  /** The kinds of the views, row by row from the upper left; each at most once. */
  readonly views: readonly string[];
  /** The shares of width and height that the first column and the first row have. */
  readonly x: number;
  readonly y: number;
}

/** Number of views of each arrangement. */
const COUNTS: Readonly<Record<Arrangement, number>> = { one: 1, beside: 2, above: 2, four: 4 };

export const LIMITS = { low: 0.15, high: 0.85 };
const HALF = 0.5;

/** A layout of views with equal shares. */
export const layoutOf = (arrangement: Arrangement, views: readonly string[]): Layout => ({
  arrangement,
  views,
  x: HALF,
  y: HALF,
});

/** The layout in another arrangement: with the views that it had, and the first of the others where there is room. */
export function arranged(layout: Layout, arrangement: Arrangement, kinds: readonly string[]): Layout {
  const others = kinds.filter((kind) => !layout.views.includes(kind));
  return { ...layout, arrangement, views: [...layout.views, ...others].slice(0, COUNTS[arrangement]) };
}

/** The layout with another view at a place; if that view has a place already, the two change theirs. */
export function withView(layout: Layout, place: number, kind: string): Layout {
  const before = layout.views[place];
  return {
    ...layout,
    views: layout.views.map((view, n) => (n === place ? kind : view === kind && before !== undefined ? before : view)),
  };
}

/** The layout with a view: as it is where it has it, else beside the only view, or in the place of the last. */
export function withAdded(layout: Layout, kind: string): Layout {
  if (layout.views.includes(kind)) return layout;
  if (layout.arrangement === "one") return { ...layout, arrangement: "beside", views: [...layout.views, kind] };
  return withView(layout, layout.views.length - 1, kind);
}

/** A layout as text for an address: `beside:map,picture:60:50`, shares in percent. */
export function written({ arrangement, views, x, y }: Layout): string {
  return [arrangement, views.join(","), Math.round(100 * x), Math.round(100 * y)].join(":");
}

/**
 * The layout of such a text; null for a text that is none. A view that is not among `kinds`, as of another visitor,
 * gives its place to the first of the others.
 */
export function read(text: string, kinds: readonly string[]): Layout | null {
  const [arrangement, list = "", ...shares] = text.split(":");
  const named = ARRANGEMENTS.find((known) => known === arrangement);
  const order = list.split(",");
  const others = kinds.filter((kind) => !order.includes(kind));
  const views = order.flatMap((view) => (kinds.includes(view) ? [view] : others.splice(0, 1)));
  const [x = Number.NaN, y = Number.NaN] = shares.map((share) => Number(share) / 100);
  const isWhole = named !== undefined && views.length === COUNTS[named] && new Set(views).size === views.length;
  if (!isWhole) return null;
  const isShare = (share: number): boolean => share >= LIMITS.low && share <= LIMITS.high;
  return { arrangement: named, views, x: isShare(x) ? x : HALF, y: isShare(y) ? y : HALF };
}
