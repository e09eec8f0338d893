/** The lessons in their order: the anchor of each on the page, and its title. */
export const LESSONS = [
  { id: "grid", title: "A grid and three assumptions" },
  { id: "cell", title: "One cell" },
  { id: "log-odds", title: "Why log-odds" },
  { id: "model", title: "What one reading says" },
  { id: "rays", title: "Rays on a grid" },
  { id: "algorithm", title: "The whole algorithm" },
  { id: "sonar", title: "Sonar and its cone" },
  { id: "no-return", title: "When nothing comes back" },
  { id: "mount", title: "Frames and mounts" },
  { id: "forgetting", title: "Clamping and forgetting" },
  { id: "counting", title: "Per beam or per scan" },
  { id: "file", title: "The file that Nav2 reads" },
  { id: "log", title: "Now your own log" },
] as const;

export type LessonId = (typeof LESSONS)[number]["id"];

export interface Lesson {
  readonly id: string;
  readonly title: string;
}
