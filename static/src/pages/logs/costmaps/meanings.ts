/** What the costs of Nav2's costmaps mean. Source: nav2_costmap_2d, cost_values.hpp. */

interface Meaning {
  /** The background that shows its colour on the map. */
  readonly token: string;
  readonly costs: string;
  readonly text: string;
}

export const MEANINGS: readonly Meaning[] = [
  { token: "var(--map-free)", costs: "0", text: "free" },
  {
    token: "linear-gradient(90deg, var(--cost-low), var(--cost-high))",
    costs: "1 … 252",
    text: "near an obstacle",
  },
  { token: "var(--cost-inscribed)", costs: "253", text: "inscribed: the robot touches an obstacle" },
  { token: "var(--cost-lethal)", costs: "254", text: "lethal: an obstacle" },
  { token: "var(--map-unobserved)", costs: "255", text: "no information" },
];

/** The cost of a cell's byte on the wire: byte 0 is no information, bytes 1 … 255 are 0 … 254. */
export const costOf = (byte: number): number => (byte === 0 ? 255 : byte - 1);

/** A cost in words. */
export function meaningOf(cost: number): string {
  if (cost === 0) return "free";
  if (cost <= 252) return "near an obstacle";
  return { 253: "inscribed", 254: "lethal" }[cost] ?? "no information";
}
