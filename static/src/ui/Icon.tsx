const PATHS = {
  play: "M7 4.5v15l12-7.5z",
  pause: "M8 5v14M16 5v14",
  stepForward: "M6 5v14l9-7zM19 5v14",
  stepBack: "M18 5v14l-9-7zM5 5v14",
  restart: "M4 12a8 8 0 1 0 2.6-5.9M4 4v4.5h4.5",
  upload: "M12 16V4M7 9l5-5 5 5M4 16v3a1 1 0 0 0 1 1h14a1 1 0 0 0 1-1v-3",
  download: "M12 4v12M7 11l5 5 5-5M4 16v3a1 1 0 0 0 1 1h14a1 1 0 0 0 1-1v-3",
  trash: "M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v5M14 11v5",
  link: "M10 14a4 4 0 0 0 5.7 0l3-3a4 4 0 0 0-5.7-5.7l-1 1M14 10a4 4 0 0 0-5.7 0l-3 3A4 4 0 0 0 11 18.7l1-1",
  info: "M12 11v5.5M12 7.6v.1M3.5 12a8.5 8.5 0 1 0 17 0 8.5 8.5 0 1 0-17 0",
  close: "M6 6l12 12M18 6L6 18",
  check: "M5 12.5l4.5 4.5L19 7.5",
  warning: "M12 4 2.8 20h18.4zM12 10v4.5M12 17.3v.1",
  sun: "M12 8a4 4 0 1 0 0 8 4 4 0 1 0 0-8M12 2.5v2M12 19.5v2M2.5 12h2M19.5 12h2M5.3 5.3l1.4 1.4M17.3 17.3l1.4 1.4M5.3 18.7l1.4-1.4M17.3 6.7l1.4-1.4",
  moon: "M20 14.5A8.5 8.5 0 0 1 9.5 4a8.5 8.5 0 1 0 10.5 10.5z",
  unfold: "M5 9l7 7 7-7",
  back: "M15 5l-7 7 7 7",
  forward: "M9 5l7 7-7 7",
  target: "M12 3v4M12 17v4M3 12h4M17 12h4M7.5 12a4.5 4.5 0 1 0 9 0 4.5 4.5 0 1 0-9 0",
  fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
  cube: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9",
  curve: "M3 16h8V6h4v6h6",
  robot: "M12 4a8 8 0 1 0 0 16 8 8 0 1 0 0-16M12 12l5.5-3.5M12 12v.1",
  gauge: "M4.5 18a8.5 8.5 0 1 1 15 0M12 16l4-6",
  wall: "M4 19L19 4M2.5 20.5l3-3M18.5 5.5l3-3",
  box: "M5 8h14v10H5z",
  erase: "M9 19l-5-5 9-9 6 6-8 8zM8.5 9.5l6 6M9 19h11",
  undo: "M8 5L4 9l4 4M4 9h9a5.5 5.5 0 0 1 0 11h-3",
  redo: "M16 5l4 4-4 4M20 9h-9a5.5 5.5 0 0 0 0 11h3",
  file: "M6 3h8l4 4v14H6zM14 3v4h4",
  map: "M4 6l5-2 6 2 5-2v14l-5 2-6-2-5 2zM9 4v14M15 6v14",
  up: "M5 15l7-7 7 7",
  grip: "M9 6v.1M15 6v.1M9 12v.1M15 12v.1M9 18v.1M15 18v.1",
  pen: "M4 20l1-4L16 5l3 3L8 19zM14 7l3 3",
  plus: "M12 5v14M5 12h14",
  viewOne: "M3 5h18v14H3z",
  viewsBeside: "M3 5h18v14H3zM12 5v14",
  viewsAbove: "M3 5h18v14H3zM3 12h18",
  viewsFour: "M3 5h18v14H3zM12 5v14M3 12h18",
  ruler: "M3 15.5L15.5 3l5.5 5.5L8.5 21zM7 11.5l2 2M10 8.5l3 3M13 5.5l2 2",
  area: "M5 6l13-2 2 13-11 3zM5 6v.1M18 4v.1M20 17v.1M9 20v.1",
  slides: "M3 5h18v11H3zM12 16v4M8 20h8",
  people:
    "M9 5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 1 0 0-7M2.5 20a6.5 6.5 0 0 1 13 0M15.5 5.4a3.5 3.5 0 0 1 0 6.2M18 14.5a6.5 6.5 0 0 1 3.5 5.5",
  notes: "M5 4h14v16H5zM8.5 8.5h7M8.5 12h7M8.5 15.5h4",
  blank: "M3 5h18v14H3zM3 5l18 14",
  hidden: "M3 12s3.5-6 9-6 9 6 9 6-3.5 6-9 6-9-6-9-6M4 20L20 4",
  shown: "M3 12s3.5-6 9-6 9 6 9 6-3.5 6-9 6-9-6-9-6M12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 1 0 0-5",
  logo: "M4 4h4v4H4zM10 4h4v4h-4zM4 10h4v4H4zM10 10h4v4h-4zM16 10h4v4h-4zM10 16h4v4h-4z",
} as const;

export type IconName = keyof typeof PATHS;

/** A line icon, 24 × 24, in the colour of the surrounding text. */
export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" aria-hidden="true" focusable="false">
      <path d={PATHS[name]} />
    </svg>
  );
}
