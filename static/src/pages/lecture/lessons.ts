/** Heights of a figure, CSS pixels: on a wide page, at a width of 768, and at a width of 390. */
export type Reserve = readonly [wide: number, middle: number, narrow: number];

/** The lessons in their order: the anchor of each on the page, its title, and the height of its figure. */
export const LESSONS = [
  { id: "landmarks", title: "Landmarks or a grid", reserve: [300, 300, 300] },
  { id: "grid", title: "A grid and three assumptions", reserve: [383, 323, 592] },
  { id: "cell", title: "One cell", reserve: [402, 402, 347] },
  { id: "log-odds", title: "Why log-odds", reserve: [579, 579, 624] },
  { id: "model", title: "The inverse sensor model", reserve: [661, 683, 804] },
  { id: "window", title: "What the window is for", reserve: [300, 300, 300] },
  { id: "endpoint", title: "From a reading to a cell", reserve: [300, 300, 300] },
  { id: "rays", title: "Rays on a grid", reserve: [678, 620, 449] },
  { id: "table", title: "Table 9.1, line by line", reserve: [300, 300, 300] },
  { id: "algorithm", title: "The algorithm beam by beam", reserve: [518, 941, 787] },
  { id: "pipeline", title: "The whole pipeline", reserve: [300, 300, 300] },
  { id: "sonar", title: "Sonar cones", reserve: [408, 381, 740] },
  { id: "no-return", title: "Beams without a return", reserve: [340, 330, 1036] },
  { id: "mount", title: "Frames and mounts", reserve: [424, 432, 834] },
  { id: "forgetting", title: "Clamping and forgetting", reserve: [657, 609, 937] },
  { id: "counting", title: "Per beam or per scan", reserve: [592, 565, 904] },
  { id: "resolution", title: "The size of a cell", reserve: [300, 300, 300] },
  { id: "polished", title: "Polished walls", reserve: [300, 300, 300] },
  { id: "people", title: "People who walk", reserve: [300, 300, 300] },
  { id: "low-table", title: "A table below the laser", reserve: [300, 300, 300] },
  { id: "doubled", title: "Walls drawn twice", reserve: [300, 300, 300] },
  { id: "odometry", title: "When the poses are not known", reserve: [446, 396, 847] },
  { id: "probable", title: "The most probable pose", reserve: [511, 594, 630] },
  { id: "matching", title: "Matching two scans", reserve: [543, 467, 907] },
  { id: "graph", title: "From matching to a graph", reserve: [901, 806, 677] },
  { id: "file", title: "The file that Nav2 reads", reserve: [658, 642, 1470] },
  { id: "next", title: "What is built on the map", reserve: [300, 300, 300] },
  { id: "log", title: "Your own log", reserve: [217, 217, 240] },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
  readonly reserve: Reserve;
}
