/** The answers of the slides with their notes. No page of a follower of a class loads this file. */

import type { LessonId } from "../lessons";
import type { Answer } from "./questions";

/** The answer to the question of each section. */
export const ANSWERS: Partial<Record<LessonId, Answer>> = {
  grid: {
    // Computed by the figure (lessons/independence/model.ts); Probabilistic Robotics, section 9.4, on what independence loses.
    right: 2,
    answer: "In the joint distribution the other two become more probable; independent cells stay as they were.",
    notes:
      "Compare the two columns of cells 3 and 5. Then let the narrow beam pass one of them: the joint distribution concludes that it is the last cell. Name the three assumptions before: a cell is occupied or free, the world is static, the cells are independent.",
  },
  cell: {
    // Probabilistic Robotics, table 4.2: the filter adds log-odds.
    right: 2,
    answer:
      "Log-odds add up, in any order until a clamp is reached: 4 · 0.85 = 3.40, and 3.40 / 0.40 = 8.5: the ninth.",
    notes:
      "Press hit four times, then miss until the line is below the prior. Let the audience count. The order does not matter: show it with alternating presses.",
  },
  "log-odds": {
    // Computed by the figure in binary32 (lessons/digits/model.ts); IEEE 754.
    right: 0,
    answer: "p rounds to exactly 1 and never comes back; the odds overflow later; the sum of log-odds keeps working.",
    notes:
      "Drag the cursor along the chart. The point where p becomes exactly 1 is marked. With a clamp none of the three fails: cost and simplicity remain as reasons.",
  },
  model: {
    // Probabilistic Robotics, table 9.2: l_free before the window, l_occ in it, l_0 behind it.
    right: 2,
    answer: "Cells passed: evidence for free. Around the end: for occupied. Behind it: none, they keep their value.",
    notes:
      "Drag the height of the curve before and around z, then the width of the window: the map beside it follows. Then drag z itself.",
  },
  rays: {
    // Bresenham 1965; Amanatides and Woo 1987.
    right: 2,
    answer: "Bresenham takes one cell per step of the longer axis; exact traversal takes every cell the beam crosses.",
    notes:
      "Drag the end of the beam once around the sensor. Switch one of the two fixes off and repeat: only some octants remain right.",
  },
  algorithm: {
    // Probabilistic Robotics, table 9.1, lines 3 to 6.
    right: 1,
    answer: "Only cells in the perceptual field get new evidence; all others keep their value.",
    notes:
      "Step through the lines of the table. Then choose “beam by beam”: the same evidence, with the loops swapped. Then “one reading”: follow it to the character at the end.",
  },
  sonar: {
    // Computed by the figure; Moravec and Elfes 1985; Probabilistic Robotics, section 9.4.1, on conflicting cones.
    right: 1,
    answer:
      "A wall: arcs from both jambs cross the door; no echo from behind contradicts them. Moravec–Elfes is less sure.",
    notes: "Add the readings one by one; the cross is in the door. Point to the arcs that lie across it.",
  },
  "no-return": {
    // Probabilistic Robotics, table 9.2 marks all cells up to z_max as free, which is right in open space and wrong at
    // glass; REP 117 keeps the two apart from a reading at the max range.
    right: 2,
    answer: "Open space: free, as in table 9.2. Glass or a polished wall: free would erase it, so it is ignored.",
    notes:
      "Drag the robot in front of the glass and compare the three maps, which are made from the same scans. Ask what happens with a driver that reports the max range.",
  },
  mount: {
    // REP 105: T_map_laser = T_map_base T_base_laser; computed by the figure (lessons/mount/model.ts).
    right: 1,
    answer: "Each scan turns about the sensor, so one wall lands in a different place from each pose that saw it.",
    notes: "Rotate the coloured fan, then shift it, then turn it upside down. Which of the three is hardest to notice?",
  },
  forgetting: {
    // Computed by the figure (lessons/forgetting/model.ts); OctoMap 2013, section 5.1, on the clamp.
    right: 2,
    answer: "The clamp bounds ℓ, so a few scans undo any hour. Without it the misses must outweigh all hits.",
    notes: "Let the audience guess a number of scans first, then remove the table. Repeat with a wider clamp.",
  },
  counting: {
    // Probabilistic Robotics, tables 9.1 and 9.2: one update of a cell for each scan.
    right: 1,
    answer: "Near the sensor many beams cross one cell: adding all of them counts the same evidence many times.",
    notes: "Drag the cross towards the robot and read how often each cell was updated, per beam and per scan.",
  },
  matching: {
    answer: "Where its scan agrees best with the last one. That needs structure, and often a good initial pose.",
    notes:
      "Let a student align the scans by hand first, then take one iteration at a time. Then the corridor: it slides.",
  },
  file: {
    // map_server reads (255 - grey) / 255 and compares it with free_thresh: 50 / 255 = 0.196.
    right: 1,
    answer: "Grey 205 means p = 0.196. Below 0.25 that is free: the robot is sent through cells that were never seen.",
    notes: "Move the reader’s free_thresh across 0.196: the image stays the same, its meaning does not.",
  },
  landmarks: {
    // Probabilistic Robotics, chapters 7 and 9.
    right: 1,
    answer: "Landmarks say where the robot is, but nothing about the space between them; a grid stores that.",
    notes:
      "Switch between the two maps of the same drive. Ask where the robot could drive by the map of landmarks alone.",
  },
  window: {
    // Probabilistic Robotics, section 6.3.1 and table 9.2; computed by the stage (lessons/stage/wall.ts).
    right: 1,
    answer: "Too narrow: the hits fall into different cells and the wall is broken. Too wide: the wall is thick.",
    notes: "Press the three presets, then raise the noise slowly with the window at 0: the wall breaks up.",
  },
  endpoint: {
    answer: "Angle and range give a point, the pose moves it into the map, origin and resolution make it a cell.",
    notes:
      "Drag the robot, then the origin to the right of the end point: rounding down, not cutting off, is what counts.",
  },
  resolution: {
    // Arithmetic: (10 / 1) squared.
    right: 1,
    answer: "Memory grows with the square: 100 times. Cells of 1 cm show the noise, cells of 10 cm narrow the door.",
    notes: "Compare the door and the pillar in the three maps, then the memory and the number of updates.",
  },
  polished: {
    // Probabilistic Robotics, section 6.3.1, on failures of a range finder.
    right: 1,
    answer: "It reflects the beam away: no return, so the wall is missing where the robot never faced it.",
    notes: "Switch the polish on and off. Name glass, metal and stone; more readings do not help.",
  },
  people: {
    // Haehnel et al. 2003; computed by the stage.
    right: 1,
    answer: "Beams that pass later clear the trail; where none do, people who left long ago stay in the map.",
    notes: "Move the slider past the moment at which the robot leaves the corridor. Which assumption is broken?",
  },
  "low-table": {
    // Geometry: a planar scan has one height.
    right: 1,
    answer: "A cell has no height: what lies below the plane of the laser appears in no reading.",
    notes: "Drag the laser up and down past the height of the table, and watch the map.",
  },
  odometry: {
    // Probabilistic Robotics, chapter 5; computed by the figure (lessons/odometry/model.ts).
    right: 1,
    answer: "Errors of raw odometry add up, those of the heading above all: a place seen again is drawn elsewhere.",
    notes: "Drag the heading error first, then the distance error. Compare the two maps.",
  },
  probable: {
    // Probabilistic Robotics, chapters 5 and 6: the product of both densities; computed by the figure.
    right: 2,
    answer:
      "The most probable pose has the greatest product of both; with doors at equal distances the odometry decides.",
    notes: "Drag the diamond along the corridor with cabinets, with doors, and bare. When is the answer wrong?",
  },
  graph: {
    // Grisetti et al. 2010: the error of a loop is spread over its poses.
    right: 2,
    answer: "A loop adds a spring to the chain of springs: its error is spread over all poses in between.",
    notes: "Pull a pose and let it go, then close the loop. Then the wrong loop, without and with a robust kernel.",
  },
  particles: {
    // Probabilistic Robotics, section 1.2 (the corridor with doors) and table 8.2.
    right: 1,
    answer: "A belief can have three peaks. Particles keep all of them, and the next readings decide.",
    notes:
      "Go through the steps: draw, drive, read. Turn the wheel by its handle: one random number for all draws. Then “independent”, and watch how many particles are left.",
  },
  "sensor-models": {
    // Probabilistic Robotics, section 9.3: the inverse model takes a prior over maps and a sum over all of them.
    right: 2,
    answer: "The probability of a cell also takes a prior over maps, and a sum over all maps in which it is occupied.",
    notes:
      "Drag the four parts first. Then z in the lower chart, and the prior: the dashed curve is low before and behind the reading, the inverse is not.",
  },
  kidnapping: {
    // Probabilistic Robotics, table 8.3.
    right: 2,
    answer: "Without random particles, none is ever near the robot. Two averages of the weights say when to add them.",
    notes:
      "Let it drive until the cloud has found the robot, then drag it away. Set both rates to 0 and repeat: it stays lost. Equal rates: the same.",
  },
  terrain: {
    // Arithmetic: the residual is a sum over the points.
    right: 2,
    answer: "The residual is a sum of squares and grows with the points; the roughness √(residual / n) stays.",
    notes:
      "Choose the ramp, then “Every point twice”: the residual doubles, the roughness does not. Drag one point up and read which entries of P change: those with its h. Then the stone, without and with RANSAC. The slope without the root is a common slip.",
  },
  layers: {
    // Nav2, obstacle layer: marks and clears by the current scan.
    right: 1,
    answer: "Each layer has its own source; the greatest cost counts. The obstacle layer marks and clears the crate.",
    notes:
      "Drag the crate out of the robot’s view, and back. Switch the layers off one by one, and read the costs under the cross. What can the obstacle layer not clear?",
  },
  inflation: {
    // Nav2, inflation_layer.hpp: cost = 252 exp(-cost_scaling_factor (distance - inscribed radius)).
    right: 0,
    answer: "Yes: the cost falls faster, so places near the wall are cheap. Many expect the opposite from the name.",
    notes:
      "Drag the point of the curve up and down, then its foot. Put the cross into the right door and make the robot wider until the door is closed.",
  },
  path: {
    // Dijkstra 1959; Hart et al. 1968; Nav2, navfn.cpp.
    right: 1,
    answer:
      "Each cell gets the least cost of reaching it; the path is traced back from the goal. A* expands fewer cells.",
    notes:
      "Drag the goal from room to room. Then play the search with Dijkstra and with A*, and compare the two numbers of cells.",
  },
  lifetime: {
    // Nav2, obstacle layer: a cell is cleared only by a ray through it.
    right: 1,
    answer:
      "Only a beam clears the obstacle layer, and the path avoids the table. A lifetime removes it after a set time.",
    notes:
      "Saved map, obstacle layer, lifetime: three answers. With the obstacle layer drag the robot near. With the lifetime move the seconds past it. Ask what a short lifetime risks.",
  },
  stack: {
    answer: "The robot saves it, finds itself on it, and plans on it; new obstacles go in a separate layer.",
    notes:
      "Play it once from the start. Then stop in the last part and drag the goal. Point at the crate: it is in the costmap, and not in the map.",
  },
  octree: {
    // Arithmetic: volume by 8, surface by 4; OctoMap 2013, section 3.
    right: 2,
    answer: "A dense grid grows with the volume, an octree with the surfaces: large empty regions are one node.",
    notes:
      "Move the cut from the floor to the ceiling: low table, open doors, lintels. Then the cells from 40 cm to 5 cm: watch the two bars change places.",
  },
  tsdf: {
    // Curless and Levoy 1996, section 3; computed by the figure.
    right: 2,
    answer:
      "The signed distance crosses zero at the mean of the readings, even within a voxel; occupancy has whole cells.",
    notes:
      "Drag the wall slowly through one cell: the bar stays, the zero crossing follows. Then the readings from 1 to 60. Drag the truncation: what is behind it? Move the wall halfway, with a maximum weight of 64 and of 4. Last: which of the two does a planner need, which one a mesh?",
  },
  next: {
    answer: "A log of your own robot: drop a bag, an MCAP or a CARMEN log on the logs page.",
    notes: "Open the logs page with a log of the audience, or with one of its sample logs.",
  },
};

/** The notes of slides that do not belong to a section: of a derivation, or by their kind. */
export const OTHER_NOTES: Readonly<Record<string, string>> = {
  title: "The map fills in as the robot drives. Ask what a cell could store, and what the colours mean.",
  "cell-derivation":
    "Ask for the next line before it is shown, and which assumption it needs: Markov twice, then independence of map and poses. Dividing by the free cell removes what is hard to know. The last line is the sum of the slide before.",
  lab: "Let the audience name a parameter and say what it will change, then change it. Take the window, the max range and the increments first.",
  log: "Open a sample log. Ask where its map is wrong and why, click a wall and read Why: which scans made it.",
};
