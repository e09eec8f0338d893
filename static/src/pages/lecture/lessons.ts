/** The lessons in order, each with its anchor on the page and its title. */
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
  { id: "algorithm", title: "The algorithm" },
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
  { id: "next", title: "Where to go from here" },
] as const satisfies readonly Lesson[];

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
}

/** A part of the lecture: consecutive lessons. */
export interface Part {
  readonly title: string;
  /** Its subject, in one sentence. */
  readonly sentence: string;
  /** Its lessons, with their indices in {@link LESSONS}. */
  readonly lessons: readonly { readonly id: LessonId; readonly title: string; readonly index: number }[];
}

const PART_STARTS: readonly { readonly title: string; readonly sentence: string; readonly first: LessonId }[] = [
  {
    title: "Mapping",
    sentence: "From one cell and one reading to the map of a building.",
    first: "landmarks",
  },
  {
    title: "When it goes wrong",
    sentence: "Frames, moving things, missing walls, drifting poses, and how each is repaired.",
    first: "mount",
  },
  {
    title: "Using the map and 3D",
    sentence: "The robot saves the map, finds itself on it and plans on it; then maps with height.",
    first: "file",
  },
];

/** The three parts of the lecture. */
export const LECTURE_PARTS: readonly Part[] = PART_STARTS.map(({ title, sentence, first }, i) => {
  const start = LESSONS.findIndex(({ id }) => id === first);
  const next = PART_STARTS[i + 1];
  const end = next ? LESSONS.findIndex(({ id }) => id === next.first) : LESSONS.length;
  return {
    title,
    sentence,
    lessons: LESSONS.slice(start, end).map((lesson, k) => ({ ...lesson, index: start + k })),
  };
});

/** Sections that were merged into another. Links and decks that name them lead to that section. */
const MERGED: Readonly<Record<string, LessonId>> = {
  table: "algorithm",
  pipeline: "algorithm",
  characters: "algorithm",
  log: "next",
};

/** The section that a name in a link or a deck refers to; the name itself if none was merged. */
export const sectionOf = (name: string): string => MERGED[name] ?? name;
