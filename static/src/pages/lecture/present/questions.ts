import type { LessonId } from "../lessons";

/** The question of a slide before its figure is shown. */
export interface Question {
  readonly question: string;
  /** The options; without them there is nothing to choose. */
  readonly options?: readonly string[];
}

/** The answer of a slide after its figure. */
export interface Answer {
  /** Index of the right option; the class shows it with the result. */
  readonly right?: number;
  /** What the figure has demonstrated. */
  readonly answer: string;
  /** Notes for the lecturer, shown only in the speaker's window. */
  readonly notes?: string;
}

/** The question of each section. A section without one shows its figure immediately. */
export const QUESTIONS: Partial<Record<LessonId, Question>> = {
  grid: {
    question: "At least one of five cells echoed; a beam passed three. What of the other two?",
    options: [
      "They become more probably occupied",
      "They keep the value after the echo",
      "It depends on how the map stores the belief",
    ],
  },
  cell: {
    question: "After four hits of +0.85, which miss of −0.40 makes free more likely?",
    options: ["The first", "The fourth", "The ninth"],
  },
  "log-odds": {
    question: "Stored in 32 bits, which breaks first: p, the odds, or the log-odds?",
    options: ["The probability p", "The odds", "The log-odds ℓ"],
  },
  model: {
    question: "A beam measures one number, z. Which cells does it say something about?",
    options: ["The cell at z", "All cells of the beam", "The cells before z and around it, not those behind"],
  },
  rays: {
    question: "A beam ends 18 columns to the right and 7 rows up. Which cells lie on its way?",
    options: ["Every cell that it touches", "One in each column", "It depends on the algorithm"],
  },
  algorithm: {
    question: "Table 9.1 visits every cell for each scan. Which of them does it change?",
    options: ["All of them", "Those in the perceptual field", "Those that were hit"],
  },
  sonar: {
    question: "Both jambs of an open door echo. What is mapped between them?",
    options: ["An opening", "A wall", "Nothing: it stays unknown"],
  },
  "no-return": {
    question: "A beam has no return. What should the map do with it?",
    options: ["Mark its cells as free", "Ignore it", "It depends on why there was no return"],
  },
  mount: {
    question: "The map assumes a mount that is 8° off. What looks wrong?",
    options: ["The whole map is turned", "Walls appear in several places", "Nothing: the error cancels"],
  },
  forgetting: {
    question: "ℓ is clamped. A table is taken away after an hour. When is it forgotten?",
    options: ["About as long again", "About twice as long", "After the same few scans, however long it stood"],
  },
  counting: {
    question: "Are all beams of one scan independent readings of a cell beside the robot?",
    options: ["Yes", "No: they share the error of that pose"],
  },
  matching: {
    question: "The odometry is wrong. How can two scans tell where the robot is?",
  },
  file: {
    question: "free_thresh is 0.25 and unknown cells have grey 205. What does a planner read?",
    options: ["Unknown", "Free", "Occupied"],
  },
  landmarks: {
    question: "A robot must not hit the walls of a new building. What should its map store?",
    options: ["Corners and poles that it recognises", "For each patch of floor: is something there?"],
  },
  window: {
    question: "Ranges are noisy by a few centimetres. How wide should the hit window be?",
    options: ["As narrow as possible", "A few times the noise", "As wide as possible"],
  },
  endpoint: {
    question: "A scan holds only distances. How does one become a row and a column?",
  },
  resolution: {
    question: "Cells of 1 cm instead of 10 cm: how much more memory is needed?",
    options: ["10 times as much", "100 times as much", "1000 times as much"],
  },
  polished: {
    question: "A wall is polished like a mirror. What does a laser see of it?",
    options: ["The wall", "Nothing, unless the beam meets it nearly head-on", "A wall twice as far away, always"],
  },
  people: {
    question: "A person walks through the field of view. What remains in the map?",
    options: ["Nothing", "A trail that stays where no later beam passes", "A trail that always stays"],
  },
  "low-table": {
    question: "The map is right about all that the laser saw. Can the robot hit a table?",
    options: ["No", "Yes, if the table is lower than the laser’s plane"],
  },
  odometry: {
    question: "A map shows the same wall twice, a little apart. What has happened?",
    options: ["The sensor is noisy", "The poses have drifted", "The window is too wide"],
  },
  probable: {
    question: "Scan and odometry disagree about the pose. Which pose is used?",
    options: ["That of the scan", "That of the odometry", "The most probable one given both"],
  },
  graph: {
    question: "The robot is at its start again; the odometry disagrees. Which pose is wrong?",
    options: ["The last one", "The first one", "All after the first, a little each"],
  },
  particles: {
    question: "A robot sees a door, and the corridor has three. Where is the robot?",
    options: [
      "At the nearest door",
      "At each of the three, with equal probability",
      "Nowhere: it needs a second reading",
    ],
  },
  "sensor-models": {
    question: "Why can’t we get the inverse model from p(z | x, m) alone?",
    options: ["It lacks a scale factor", "It is too noisy", "It is a distribution over readings, not over the cell"],
  },
  kidnapping: {
    question: "All particles are in one room; the robot is carried to another. Is it found?",
    options: ["Yes, the particles follow the scans", "Never", "Only with random particles among them"],
  },
  terrain: {
    question: "9 points leave a residual of 0.4 m². Each is measured twice: what is it now?",
    options: ["0.2 m²", "0.4 m²", "0.8 m²"],
  },
  layers: {
    question: "A crate in the way is not in the saved map. Which layer has it?",
    options: ["The static layer", "The obstacle layer", "The inflation layer"],
  },
  inflation: {
    question: "cost_scaling_factor is doubled. Do paths come nearer to the walls?",
    options: ["Yes", "No, they keep away"],
  },
  path: {
    question: "How does a robot find the cheapest path without trying all of them?",
    options: [
      "It drives straight and turns at obstacles",
      "It spreads costs from cell to cell, like a wave",
      "It learns the path from earlier drives",
    ],
  },
  lifetime: {
    question: "The table is gone, and the robot still drives around it. Why?",
    options: ["The planner is slow", "No beam has passed there since", "The laser is too low"],
  },
  stack: {
    question: "What does a robot do with the finished map?",
  },
  octree: {
    question: "A building in cells of 5 cm instead of 10 cm, in 3D: how much more memory?",
    options: ["2 times as much", "4 times as much", "8 times, or 4 with an octree"],
  },
  tsdf: {
    question: "Voxels of 10 cm, noise of 2 cm: how precisely can a wall be located?",
    options: ["To 10 cm, the voxel", "To 2 cm, the noise", "Better than both, from many readings"],
  },
  next: {
    question: "What would you map next?",
  },
};
