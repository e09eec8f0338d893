/** Heights of a figure, CSS pixels: on a wide page, at a width of 768, and at a width of 390. */
export type Reserve = readonly [wide: number, middle: number, narrow: number];

/** The lessons in their order: the anchor of each on the page, its title, and the height of its figure. */
export const LESSONS = [
  { id: "landmarks", title: "Landmarks or a grid", reserve: [395, 350, 574] },
  { id: "grid", title: "A grid and three assumptions", reserve: [318, 324, 606] },
  { id: "cell", title: "One cell", reserve: [454, 454, 350] },
  { id: "log-odds", title: "Why log-odds", reserve: [587, 587, 609] },
  { id: "model", title: "The inverse sensor model", reserve: [721, 704, 825] },
  { id: "window", title: "What the window is for", reserve: [122, 122, 193] },
  { id: "endpoint", title: "From a reading to a cell", reserve: [186, 178, 271] },
  { id: "rays", title: "Rays on a grid", reserve: [542, 628, 420] },
  { id: "table", title: "Table 9.1, line by line", reserve: [427, 427, 527] },
  { id: "algorithm", title: "The algorithm beam by beam", reserve: [578, 969, 823] },
  { id: "pipeline", title: "The whole pipeline", reserve: [1353, 1331, 1242] },
  { id: "sonar", title: "Sonar cones", reserve: [344, 365, 751] },
  { id: "no-return", title: "Beams without a return", reserve: [401, 385, 1092] },
  { id: "mount", title: "Frames and mounts", reserve: [477, 482, 896] },
  { id: "forgetting", title: "Clamping and forgetting", reserve: [642, 684, 1024] },
  { id: "counting", title: "Per beam or per scan", reserve: [600, 621, 961] },
  { id: "resolution", title: "The size of a cell", reserve: [270, 279, 1126] },
  { id: "polished", title: "Polished walls", reserve: [40, 40, 40] },
  { id: "people", title: "People who walk", reserve: [114, 114, 114] },
  { id: "low-table", title: "A table below the laser", reserve: [192, 192, 215] },
  { id: "doubled", title: "Walls drawn twice", reserve: [66, 66, 66] },
  { id: "odometry", title: "When the poses are not known", reserve: [465, 395, 855] },
  { id: "probable", title: "The most probable pose", reserve: [567, 576, 624] },
  { id: "matching", title: "Matching two scans", reserve: [495, 467, 907] },
  { id: "graph", title: "From matching to a graph", reserve: [745, 816, 690] },
  { id: "file", title: "The file that Nav2 reads", reserve: [718, 746, 1595] },
  { id: "next", title: "What is built on the map", reserve: [336, 292, 493] },
  { id: "log", title: "Your own log", reserve: [230, 230, 230] },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
  readonly reserve: Reserve;
}
