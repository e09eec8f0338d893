/** The text of the front page's first screen, which its HTML contains before its script runs. */

export const TITLE = "Watch a map fill in";

interface Noun {
  /** Its colour in the figures. */
  readonly tone: "robot" | "beam" | "miss" | "hit";
  readonly text: string;
}

export const SENTENCE: readonly (string | Noun)[] = [
  "A ",
  { tone: "robot", text: "robot" },
  " explores unknown rooms. Cells its ",
  { tone: "beam", text: "laser beams" },
  " cross are probably ",
  { tone: "miss", text: "free" },
  ", the cells they hit probably ",
  { tone: "hit", text: "occupied" },
  "; the map sums the evidence.",
];

export const LAB = { href: "/lab.html", label: "Open the lab" } as const;
export const LOGS = { href: "/logs.html", label: "Open a robot log" } as const;
export const MORE = { href: "#cell", label: "One cell, the lecture, your own log" } as const;

interface LegendEntry {
  readonly name: string;
  readonly label: string;
  /** Further text, shown if there is room. */
  readonly note?: string;
}

/** The colours of the map. */
export const LEGEND: readonly LegendEntry[] = [
  { name: "occupied", label: "occupied" },
  { name: "free", label: "free", note: " (white in RViz)" },
  { name: "undecided", label: "unknown" },
  { name: "unobserved", label: "never seen" },
];
