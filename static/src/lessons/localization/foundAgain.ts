/** The question of the kidnapped robot: how many scans it takes until the particles have found it. */

import { advance, firstState, INITIAL } from "./kidnap";
import { continueWalk, settings } from "./state";

const MOST_SCANS = 200;
const MOST_OF_THE_BELIEF = 0.5;

/** Continue the first walk of the figure until the robot is found; return the scans since its first state. */
export function foundAgain(): number {
  let walk = firstState(INITIAL);
  const before = walk.past.length;
  while ((walk.past.at(-1)?.near ?? 0) <= MOST_OF_THE_BELIEF && walk.past.length < before + MOST_SCANS) {
    walk = advance(walk, INITIAL);
  }
  settings.value = INITIAL;
  continueWalk(() => walk);
  return walk.past.length - before;
}
