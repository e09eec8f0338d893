/** Heights of a figure, CSS pixels: on a wide page, on a tablet of 768, and on a phone of 390. */
export type Reserve = readonly [wide: number, middle: number, narrow: number];

/** The lessons in their order: the anchor of each on the page, its title, and the place that its figure needs. */
export const LESSONS = [
  { id: "grid", title: "A grid and three assumptions", reserve: [383, 323, 585] },
  { id: "cell", title: "One cell", reserve: [402, 402, 359] },
  { id: "log-odds", title: "Why log-odds", reserve: [579, 579, 624] },
  { id: "model", title: "What one reading says", reserve: [638, 661, 798] },
  { id: "rays", title: "Rays on a grid", reserve: [678, 620, 449] },
  { id: "algorithm", title: "The whole algorithm", reserve: [518, 941, 787] },
  { id: "sonar", title: "Sonar and its cone", reserve: [408, 381, 740] },
  { id: "no-return", title: "When nothing comes back", reserve: [340, 372, 1036] },
  { id: "mount", title: "Frames and mounts", reserve: [424, 432, 812] },
  { id: "forgetting", title: "Clamping and forgetting", reserve: [657, 609, 944] },
  { id: "counting", title: "Per beam or per scan", reserve: [592, 565, 904] },
  { id: "file", title: "The file that Nav2 reads", reserve: [658, 626, 1454] },
  { id: "log", title: "Now your own log", reserve: [217, 217, 285] },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
  readonly reserve: Reserve;
}
