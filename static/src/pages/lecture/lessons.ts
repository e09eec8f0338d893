/** The lessons in their order: the anchor of each on the page, and its title. */
export const LESSONS = [
  { id: "landmarks", title: "Landmarks or a grid" },
  { id: "grid", title: "A grid and three assumptions" },
  { id: "cell", title: "One cell" },
  { id: "log-odds", title: "Why log-odds" },
  { id: "model", title: "The inverse sensor model" },
  { id: "window", title: "What the window is for" },
  { id: "no-return", title: "Beams without a return" },
  { id: "endpoint", title: "From a reading to a cell" },
  { id: "rays", title: "Rays on a grid" },
  { id: "table", title: "Table 9.1, line by line" },
  { id: "algorithm", title: "The algorithm beam by beam" },
  { id: "pipeline", title: "The whole pipeline" },
  { id: "characters", title: "A map of characters" },
  { id: "sonar", title: "Sonar cones" },
  { id: "mount", title: "Frames and mounts" },
  { id: "forgetting", title: "Clamping and forgetting" },
  { id: "counting", title: "Per beam or per scan" },
  { id: "resolution", title: "The size of a cell" },
  { id: "polished", title: "Polished walls" },
  { id: "people", title: "People who walk" },
  { id: "low-table", title: "A table below the laser" },
  { id: "odometry", title: "When the poses are not known" },
  { id: "probable", title: "The most probable pose" },
  { id: "matching", title: "Matching two scans" },
  { id: "graph", title: "From matching to a graph" },
  { id: "file", title: "The file that Nav2 reads" },
  { id: "particles", title: "From a belief to particles" },
  { id: "sensor-models", title: "Two sensor models" },
  { id: "kidnapping", title: "The kidnapped robot" },
  { id: "layers", title: "Layers of costs" },
  { id: "inflation", title: "Inflation" },
  { id: "path", title: "A path" },
  { id: "lifetime", title: "Obstacles that move" },
  { id: "stack", title: "The whole stack" },
  { id: "octree", title: "Why a plane is not enough" },
  { id: "tsdf", title: "TSDF beside occupancy" },
  { id: "terrain", title: "Terrain from points to classes" },
  { id: "next", title: "Other maps" },
  { id: "log", title: "Your own log" },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
}
