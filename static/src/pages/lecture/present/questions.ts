import type { LessonId } from "../lessons";

/** What a slide asks before it shows its figure. */
export interface Question {
  readonly question: string;
  /** What the audience may predict; without them there is nothing to choose. */
  readonly options?: readonly string[];
  /** Index of the right option. */
  readonly right?: number;
  /** What the figure has shown. */
  readonly answer: string;
  /** What the lecturer may say and do; only the speaker's window shows it. */
  readonly notes: string;
}

/** The question of each section; a section without one shows its figure at once. */
export const QUESTIONS: Partial<Record<LessonId, Question>> = {
  grid: {
    question: "One of five cells caused an echo, and four are found empty. What of the fifth?",
    options: ["Its probability of occupied rises", "It stays as the echo left it", "It depends on the map’s algorithm"],
    right: 2,
    answer: "The joint distribution concludes that it is the fifth cell; a grid of independent cells cannot.",
    notes:
      "Press the cells one after the other: let the narrow beam pass all but one. Compare the two bars of that cell. Name the three assumptions before: a cell is occupied or free, the world is static, the cells are independent.",
  },
  cell: {
    question: "A cell was hit four times. What does it take to be back where it began?",
    options: ["One miss", "As many misses as hits", "Misses that sum to what the hits added"],
    right: 2,
    answer: "The log-odds add up: hits and misses cancel by their sum, in any order, while no clamp is reached.",
    notes:
      "Press hit four times, then miss until the line is at the prior again. Let the audience count. The order does not matter: show it with alternating presses.",
  },
  "log-odds": {
    question: "In 32 bits, as p, as odds, as log-odds: which fails first?",
    options: ["The probability p", "The odds", "The log-odds ℓ"],
    right: 0,
    answer: "p rounds to exactly 1 and never comes back; the odds overflow later; the sum of log-odds goes on working.",
    notes:
      "Drag the cursor along the chart. The point where p becomes exactly 1 is marked. With the mapper’s clamp none of the three fails: cost and simplicity remain as reasons.",
  },
  model: {
    question: "One number, z: which cells does a reading say something about?",
    options: ["The cell at z", "All cells of the beam", "The cells before z and around it, not those behind"],
    right: 2,
    answer:
      "Passed: evidence for free. Around the end: evidence for occupied. Behind: none, the cells keep their value.",
    notes:
      "Drag the height of the curve before and around z, then the width of the window. The row of cells below is one beam.",
  },
  rays: {
    question: "A beam goes from cell (0, 0) to cell (4, 3). Which cells lie on its way?",
    options: ["Every cell that it touches", "One in each column", "It depends on the algorithm"],
    right: 2,
    answer: "Bresenham takes one cell per step of the longer axis; exact traversal takes every cell the beam crosses.",
    notes:
      "Drag the end of the beam once around the sensor. Switch one of the two fixes off and repeat: only some octants remain right.",
  },
  algorithm: {
    question: "What does the whole program do with one scan, line by line?",
    answer: "For each beam: find its cells, look up the evidence of each, add it. Nothing else.",
    notes: "Step by line first, then by cell, by beam and by scan. Drag the robot and let it run from there.",
  },
  sonar: {
    question: "Sonars look through an open door from both sides. What does the map show in the door?",
    options: ["An opening", "A wall", "It depends on the method"],
    right: 2,
    answer: "Bayes’ filter, cell by cell, marks whole arcs and closes the door; Moravec and Elfes keep it open.",
    notes: "Add the readings one by one, the cross is in the door. Point to the arcs that lie across it.",
  },
  "no-return": {
    question: "A beam comes back without an echo. What should the map do with it?",
    options: ["Mark its cells as free", "Ignore it", "Mark the end of its range as occupied"],
    right: 1,
    answer: "Ignoring is the default here: “free” erases glass, and max range taken as a hit builds a false wall.",
    notes: "Drag the robot in front of the glass. Compare the three maps, which are made from the same scans.",
  },
  mount: {
    question: "The map is made with a sensor mount turned by 8°. What looks wrong?",
    options: ["The whole map is turned", "Walls are seen in two places", "Nothing: the error cancels"],
    right: 1,
    answer: "Each scan turns about the sensor, so one wall lands in a different place from each pose that saw it.",
    notes: "Rotate the coloured fan, then shift it, then turn it upside down. Which of the three is hardest to notice?",
  },
  forgetting: {
    question: "A table stood there for an hour and is taken away. When does the map forget it?",
    options: ["About as long again", "About twice as long", "After the same few scans, however long it stood"],
    right: 2,
    answer: "That is what the clamp is for: it bounds the certainty. Without it, all hits have to be outweighed.",
    notes: "Let the audience guess a number of scans first, then remove the table. Repeat with a wider clamp.",
  },
  counting: {
    question: "Are all beams of one scan independent readings of a cell beside the robot?",
    options: ["Yes", "No: they share the error of that pose"],
    right: 1,
    answer: "Near the sensor many beams cross one cell: adding all of them counts the same evidence many times.",
    notes: "Drag the cross towards the robot and read how often each cell was updated, per beam and per scan.",
  },
  matching: {
    question: "The odometry is wrong. How can two scans tell where the robot is?",
    answer:
      "Lay the scan over the last one: the pose where both agree best. It needs structure, and often a good start.",
    notes: "Let somebody lay the scans over each other by hand first, then press ICP. Then the corridor: it slides.",
  },
  file: {
    question: "free_thresh is 0.25, an unknown cell is grey 205. What does a planner read?",
    options: ["Unknown", "Free", "Occupied"],
    right: 1,
    answer: "Grey 205 is 0.196. Below 0.25 that is free: the robot is sent through cells that nobody has seen.",
    notes: "Move the reader’s free_thresh across 0.196: the image stays the same, its meaning does not.",
  },
  log: {
    question: "What does your own robot’s log look like as a map?",
    answer: "Drop a bag, an MCAP or a CARMEN log: its map fills in, and the doctor looks for faults.",
    notes: "A log of the audience is the best one. The sample log is there otherwise.",
  },
};
