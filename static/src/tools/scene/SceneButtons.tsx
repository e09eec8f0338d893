/** The buttons of a 3D view's cameras and layers. */

import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import type { SceneSettings } from "../../wire/http";
import { scaleText } from "../measure/model";
import { changeScene } from "./settings";

interface SceneButtonsProps {
  readonly store: Store;
  readonly session: string;
}

export function SceneButtons({ store, session }: SceneButtonsProps) {
  const now = store.part("scene").message.value;
  if (!now) return null; // all of them come at once, so that none moves when others come
  const change = (wanted: SceneSettings): void => void changeScene(session, wanted);
  return (
    <>
      <fieldset class="actions" aria-label="Camera">
        {now.cameras.map((camera) => (
          <Button key={camera} onClick={() => change({ camera })}>
            {camera.charAt(0).toUpperCase() + camera.slice(1)}
          </Button>
        ))}
      </fieldset>
      <fieldset class="actions" aria-label="Layers">
        {Object.entries(now.layers).map(([label, isShown]) => (
          <Button key={label} pressed={isShown} onClick={() => change({ layers: { [label]: !isShown } })}>
            {label === "Grid" ? `Grid of ${scaleText(now.grid)}` : label}
          </Button>
        ))}
      </fieldset>
    </>
  );
}
