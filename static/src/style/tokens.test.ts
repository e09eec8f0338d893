import { describe, expect, test } from "vitest";
import type { Rgb } from "./colour";
import { toLab } from "./oklab";
import css from "./tokens.css?raw";

type Matrix = readonly (readonly [number, number, number])[];

/**
 * What is left of linear RGB where one kind of cone is missing. Source: Machado, Oliveira & Fernandes, A
 * physiologically-based model for simulation of color vision deficiency, 2009, table 1, severity 1.
 */
const EYES: Readonly<Record<string, Matrix>> = {
  "all cones": [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  protanopia: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deuteranopia: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
  tritanopia: [
    [1.255528, -0.076749, -0.178779],
    [-0.078411, 0.930809, 0.147602],
    [0.004733, 0.691367, 0.3039],
  ],
};

const linear = (byte: number): number => {
  const c = byte / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
};
const byte = (c: number): number => {
  const v = Math.min(1, Math.max(0, c));
  return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
};

function seenBy(eye: Matrix, rgb: Rgb): Rgb {
  const [r, g, b] = [linear(rgb[0]), linear(rgb[1]), linear(rgb[2])];
  const [red, green, blue] = eye.map(([x, y, z]) => byte(x * r + y * g + z * b));
  return [red ?? 0, green ?? 0, blue ?? 0];
}

const THEMES = ["light", "dark"] as const;

function token(name: string, theme: (typeof THEMES)[number]): Rgb {
  const found = css.match(new RegExp(`--${name}: light-dark\\(#([0-9a-f]{6}), #([0-9a-f]{6})\\)`));
  const hex = found?.[theme === "light" ? 1 : 2];
  if (!hex) throw new Error(`no token --${name}`);
  return [0, 2, 4].map((at) => Number.parseInt(hex.slice(at, at + 2), 16)) as unknown as Rgb;
}

/** Distance in OKLab, in which 0.02 is just noticeable (Ottosson 2020). */
const apart = (a: Rgb, b: Rgb): number => {
  const [from, to] = [toLab(a), toLab(b)];
  return Math.hypot(from[0] - to[0], from[1] - to[1], from[2] - to[2]);
};

/** What stands side by side and means different things, and how far apart it has to be. */
const PAIRS: readonly (readonly [a: string, b: string, least: number])[] = [
  // a map's four states
  ["map-occupied", "map-free", 0.3],
  ["map-occupied", "map-undecided", 0.3],
  ["map-occupied", "map-unobserved", 0.3],
  ["map-free", "map-undecided", 0.07],
  ["map-free", "map-unobserved", 0.07],
  ["map-undecided", "map-unobserved", 0.07],
  // hit, miss and neither: words and lines, cells, the grounds of charts
  ["hit", "miss", 0.15],
  ["hit", "prior", 0.07],
  ["miss", "prior", 0.07],
  ["hit-fill", "miss-fill", 0.15],
  ["hit-fill", "prior-fill", 0.1],
  ["miss-fill", "prior-fill", 0.1],
  ["hit-wash", "miss-wash", 0.07],
  ["hit-wash", "prior-wash", 0.035],
  ["miss-wash", "prior-wash", 0.035],
  // the reading among them, and the robot that took it
  ["beam", "hit", 0.1],
  ["beam", "miss", 0.055],
  ["beam", "robot", 0.07],
  ["hit", "robot", 0.1],
  // two maps compared: what has become less and what more occupied, beside the walls of both and the floor
  ["difference-less", "difference-more", 0.15],
  ["difference-less", "difference-wall", 0.1],
  ["difference-more", "difference-wall", 0.1],
  ["difference-less", "map-free", 0.15],
  ["difference-more", "map-free", 0.15],
  ["difference-wall", "map-free", 0.1],
  // right and wrong
  ["danger", "accent", 0.08],
];

describe.each(THEMES)("colours in the %s theme", (theme) => {
  test.each(Object.entries(EYES))("can be distinguished: %s", (_, eye) => {
    for (const [a, b, least] of PAIRS) {
      const distance = apart(seenBy(eye, token(a, theme)), seenBy(eye, token(b, theme)));
      expect(distance, `${a} and ${b}`).toBeGreaterThan(least);
    }
  });
});

test("the simulated eyes see as they should", () => {
  // Grey stays grey, and the confusions of the textbooks are there: red and green, blue and green.
  for (const eye of Object.values(EYES)) {
    for (const value of seenBy(eye, [128, 128, 128])) expect(value).toBeCloseTo(128, 0);
  }
  const { protanopia = [], deuteranopia = [], tritanopia = [], "all cones": all = [] } = EYES;
  const [red, green]: readonly Rgb[] = [
    [190, 80, 60],
    [110, 115, 50],
  ];
  const shrinks = (eye: Matrix, a: Rgb = [0, 0, 0], b: Rgb = [0, 0, 0]): number =>
    apart(seenBy(eye, a), seenBy(eye, b)) / apart(seenBy(all, a), seenBy(all, b));
  expect(shrinks(deuteranopia, red, green)).toBeLessThan(0.5);
  expect(shrinks(protanopia, red, green)).toBeLessThan(0.75);
  expect(shrinks(tritanopia, [40, 110, 200], [10, 125, 120])).toBeLessThan(0.5);
});

test("every custom property that styles and drawings use is defined", () => {
  const files: Record<string, string> = import.meta.glob("../**/*.{css,ts,tsx}", {
    eager: true,
    import: "default",
    query: "?raw",
  });
  const text = Object.values(files).join("\n");
  const defined = new Set([...text.matchAll(/["'\s{;](--[a-z][\w-]*)["']?\]?\s*:/g)].map((match) => match[1]));
  const used = [...text.matchAll(/(?:var|colourOf|resolved)\(\s*["']?(--[a-z][\w-]*)["']?\s*\)/g)].map((m) => m[1]);
  expect(used.length).toBeGreaterThan(500);
  expect([...new Set(used)].filter((name) => !defined.has(name))).toEqual([]);
});

test("every size of text is one of the type scale, or relative to another one", () => {
  const files: Record<string, string> = import.meta.glob("../**/*.css", {
    eager: true,
    import: "default",
    query: "?raw",
  });
  const own: string[] = [];
  for (const [name, text] of Object.entries(files)) {
    const [screen = ""] = text.split("@media print"); // points on paper
    for (const [rule, size = ""] of screen.matchAll(/font(?:-size)?: ([^;]*);/g))
      if (/\d(px|rem|pt)\b/.test(size)) own.push(`${name}: ${rule}`);
  }
  expect(Object.keys(files).length).toBeGreaterThan(20);
  expect(own).toEqual([]);
});
