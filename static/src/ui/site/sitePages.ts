/** The pages that the header of each page leads to. */
export const SITE_PAGES = [
  { href: "/lecture.html", label: "Lecture", id: "lecture" },
  { href: "/lab.html", label: "Lab", id: "lab" },
  { href: "/logs.html", label: "Logs", id: "logs" },
  { href: "/puzzles.html", label: "Puzzles", id: "puzzles" },
] as const;
