import { computed, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { backToPath, isOffPath } from "../../lessons/stage/path";
import { isScene, SCENES, type SceneId } from "../../lessons/stage/scenes";
import { WorldStage } from "../../lessons/stage/WorldStage";
import { Button } from "../../ui/Button";
import { onScroll } from "../../ui/browser/scrollAnchor";
import "./lectureStage.css";

const sceneInSight = signal<SceneId>("start");

/** The reading line, as a fraction of the height below the stage. */
const LINE = 0.5;

/** Find the scene in view; `covered` pixels at the top of the window are behind the stage. */
function lookForScene(covered: number): void {
  const line = covered + LINE * (innerHeight - covered);
  const places = [...document.querySelectorAll<HTMLElement>("[data-scene]")];
  const scene = places
    .filter((place) => place.getBoundingClientRect().top < line)
    .map((place) => place.dataset.scene)
    .findLast(isScene);
  const next = scene ?? "start";
  if (next !== sceneInSight.peek()) sceneInSight.value = next;
}

const scene = computed(() => SCENES[sceneInSight.value]());

/** The stage beside the text, or above it as a strip on narrow screens. */
export function LectureStage() {
  const root = useRef<HTMLElement>(null);
  useEffect(
    () =>
      onScroll(() => {
        const box = root.current?.getBoundingClientRect();
        // A strip covers the top of the text; a stage beside the text covers nothing.
        lookForScene(box && box.width > 0.7 * innerWidth ? Math.max(0, box.bottom) : 0);
      }),
    [],
  );
  return (
    <aside class="lecture-stage no-print" aria-label="Stage" data-shown={sceneInSight.value} ref={root}>
      <WorldStage scene={scene}>
        <p class="lecture-stage-back" role="status">
          {isOffPath.value && (
            <Button icon="restart" onClick={backToPath}>
              Back<span class="lecture-stage-where"> to the lecture’s path</span>
            </Button>
          )}
        </p>
      </WorldStage>
    </aside>
  );
}
