/** Heights of a figure, CSS pixels: beside the stage, on a page of 1024 pixels, of 768, and of 390. */
export type Reserve = readonly [wide: number, full: number, middle: number, narrow: number];

/** The lessons in their order: the anchor of each on the page, its title, and the height of its figure. */
export const LESSONS = [
  { id: "landmarks", title: "Landmarks or a grid", reserve: [395, 328, 350, 574] },
  { id: "grid", title: "A grid and three assumptions", reserve: [318, 408, 324, 606] },
  { id: "cell", title: "One cell", reserve: [454, 454, 454, 350] },
  { id: "log-odds", title: "Why log-odds", reserve: [587, 587, 587, 609] },
  { id: "model", title: "The inverse sensor model", reserve: [721, 680, 721, 881] },
  { id: "window", title: "What the window is for", reserve: [122, 122, 122, 193] },
  { id: "no-return", title: "Beams without a return", reserve: [401, 430, 385, 1092] },
  { id: "endpoint", title: "From a reading to a cell", reserve: [186, 178, 178, 271] },
  { id: "rays", title: "Rays on a grid", reserve: [542, 723, 628, 420] },
  { id: "table", title: "Table 9.1, line by line", reserve: [427, 427, 427, 527] },
  { id: "algorithm", title: "The algorithm beam by beam", reserve: [578, 552, 969, 823] },
  { id: "pipeline", title: "The whole pipeline", reserve: [592, 592, 592, 676] },
  { id: "characters", title: "A map of characters", reserve: [753, 731, 731, 558] },
  { id: "sonar", title: "Sonar cones", reserve: [344, 434, 365, 751] },
  { id: "mount", title: "Frames and mounts", reserve: [477, 517, 482, 896] },
  { id: "forgetting", title: "Clamping and forgetting", reserve: [642, 752, 684, 1024] },
  { id: "counting", title: "Per beam or per scan", reserve: [600, 690, 621, 961] },
  { id: "resolution", title: "The size of a cell", reserve: [322, 404, 353, 1178] },
  { id: "polished", title: "Polished walls", reserve: [40, 40, 40, 40] },
  { id: "people", title: "People who walk", reserve: [114, 114, 114, 114] },
  { id: "low-table", title: "A table below the laser", reserve: [192, 192, 192, 215] },
  { id: "odometry", title: "When the poses are not known", reserve: [531, 532, 461, 928] },
  { id: "probable", title: "The most probable pose", reserve: [567, 532, 576, 624] },
  { id: "matching", title: "Matching two scans", reserve: [495, 543, 467, 907] },
  { id: "graph", title: "From matching to a graph", reserve: [745, 917, 816, 690] },
  { id: "file", title: "The file that Nav2 reads", reserve: [718, 673, 746, 1595] },
  { id: "particles", title: "From a belief to particles", reserve: [505, 434, 505, 811] },
  { id: "sensor-models", title: "Two sensor models", reserve: [714, 667, 714, 826] },
  { id: "kidnapping", title: "The kidnapped robot", reserve: [448, 404, 404, 565] },
  { id: "layers", title: "Layers of costs", reserve: [506, 479, 479, 534] },
  { id: "inflation", title: "Inflation", reserve: [296, 296, 296, 296] },
  { id: "path", title: "A path", reserve: [269, 197, 267, 337] },
  { id: "lifetime", title: "What the moving table teaches", reserve: [150, 82, 126, 228] },
  { id: "stack", title: "The whole stack", reserve: [406, 350, 350, 534] },
  { id: "octree", title: "Why a plane is not enough", reserve: [314, 314, 314, 455] },
  { id: "tsdf", title: "TSDF beside occupancy", reserve: [780, 709, 717, 973] },
  { id: "terrain", title: "Terrain from points to classes", reserve: [718, 671, 691, 965] },
  { id: "next", title: "Other maps", reserve: [329, 217, 307, 486] },
  { id: "log", title: "Your own log", reserve: [230, 230, 230, 230] },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
  readonly reserve: Reserve;
}
