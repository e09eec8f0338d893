/** Scenes to try: a button for the next step of each, and what to look for after it. */

import { effect, signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { SCENES, type Scene, WORLD } from "./scenes";

interface Shown {
  readonly scene: Scene;
  readonly step: number;
}

/** Of a store the scene that it shows; it stays while another group is open. */
const SHOWN = new WeakMap<Store, ReturnType<typeof signal<Shown | null>>>();

function shownOf(store: Store) {
  const known = SHOWN.get(store);
  if (known) return known;
  const made = signal<Shown | null>(null);
  SHOWN.set(store, made);
  return made;
}

export function Scenes({ store }: { readonly store: Store }) {
  const shown = useMemo(() => shownOf(store), [store]);
  const now = shown.value ?? null;
  const run = (scene: Scene): void => {
    const step = now?.scene === scene ? (now.step + 1) % scene.steps.length : 0;
    const begin = (): void => scene.steps[step]?.run(store);
    shown.value = { scene, step };
    if (store.world.peek()?.name === WORLD) begin();
    else {
      store.chooseWorld(WORLD);
      when(() => store.world.value?.name === WORLD, begin);
    }
  };
  return (
    <section class="stack-narrow" aria-label="Try">
      <h2>Try</h2>
      {SCENES.map((scene) => {
        const isShown = now?.scene === scene;
        const next = isShown ? (now.step + 1) % scene.steps.length : 0;
        return (
          <div key={scene.name} class={isShown ? "navigation-scene shown" : "navigation-scene"}>
            <span>{scene.label}</span>
            <button type="button" class={`button${isShown && next > 0 ? " primary" : ""}`} onClick={() => run(scene)}>
              {scene.steps[next]?.label}
            </button>
            <p role="status">
              {isShown && (
                <>
                  <b>Look for:</b> {scene.steps[now.step]?.look}
                </>
              )}
            </p>
          </div>
        );
      })}
    </section>
  );
}

/** Do `task` once `isReady`, which reads signals, is true. */
function when(isReady: () => boolean, task: () => void): void {
  let isDone = false;
  const stop = effect(() => {
    if (isDone || !isReady()) return;
    isDone = true;
    queueMicrotask(() => {
      stop();
      task();
    });
  });
}
