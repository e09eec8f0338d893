/** Which scene of the stage belongs to what is being read: the last one whose place is above the reading line. */

import { signal } from "@preact/signals";
import { isScene, type SceneId } from "../../lessons/stage/scenes";

export const sceneInSight = signal<SceneId>("start");

/** The reading line, as a fraction of the height that the stage leaves free. */
const LINE = 0.5;

/** Find the scene in sight; `covered` pixels at the top of the window are behind the stage. */
export function lookForScene(covered: number): void {
  const line = covered + LINE * (innerHeight - covered);
  const places = [...document.querySelectorAll<HTMLElement>("[data-scene]")];
  const found = places
    .filter((place) => place.getBoundingClientRect().top < line)
    .map((place) => place.dataset.scene)
    .findLast(isScene);
  const next = found ?? "start";
  if (next !== sceneInSight.peek()) sceneInSight.value = next;
}
