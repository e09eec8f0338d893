/** Heights of a figure, CSS pixels: on a wide page, at a width of 768, and at a width of 390. */
export type Reserve = readonly [wide: number, middle: number, narrow: number];

/** The lessons in their order: the anchor of each on the page, its title, and the height of its figure. */
export const LESSONS = [
  { id: "grid", title: "A grid and three assumptions", reserve: [408, 324, 606] },
  { id: "cell", title: "One cell", reserve: [428, 428, 332] },
  { id: "log-odds", title: "Why log-odds", reserve: [587, 587, 609] },
  { id: "model", title: "The inverse sensor model", reserve: [674, 698, 819] },
  { id: "rays", title: "Rays on a grid", reserve: [723, 628, 420] },
  { id: "algorithm", title: "The whole algorithm", reserve: [552, 969, 823] },
  { id: "sonar", title: "Sonar cones", reserve: [434, 365, 751] },
  { id: "no-return", title: "Beams without a return", reserve: [358, 671, 1020] },
  { id: "mount", title: "Frames and mounts", reserve: [450, 416, 823] },
  { id: "forgetting", title: "Clamping and forgetting", reserve: [686, 618, 951] },
  { id: "counting", title: "Per beam or per scan", reserve: [618, 549, 889] },
  { id: "matching", title: "When the poses are not known", reserve: [543, 467, 907] },
  { id: "file", title: "The file that Nav2 reads", reserve: [673, 1083, 1595] },
  { id: "log", title: "Your own log", reserve: [230, 230, 230] },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
  readonly reserve: Reserve;
}
