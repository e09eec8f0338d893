/** The buttons of a 3D view's cameras and layers. */

import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { saveAs } from "../../ui/files/saveAs";
import { toast } from "../../ui/Toast";
import { Tooltip } from "../../ui/Tooltip";
import type { SceneSettings } from "../../wire/http";
import { scaleText } from "../measure/model";
import { changeScene } from "./SceneFrame";

/** Save the 3D view in a part of the page, on the background of its page, as a PNG with the same number of pixels. */
export function savePicture(part: HTMLElement | null): void {
  const inside = part?.querySelector("iframe")?.contentDocument;
  const drawn = inside?.querySelector<HTMLCanvasElement>("canvas[data-engine]");
  const picture = document.createElement("canvas");
  const ctx = picture.getContext("2d");
  if (!inside || !drawn || !ctx) {
    toast("The 3D view has not loaded yet.", "error");
    return;
  }
  picture.width = drawn.width;
  picture.height = drawn.height;
  ctx.fillStyle = getComputedStyle(inside.body).backgroundColor;
  ctx.fillRect(0, 0, picture.width, picture.height);
  ctx.drawImage(drawn, 0, 0);
  picture.toBlob((png) => png && saveAs("view.png", png));
}

const GESTURES =
  "Drag to turn. Drag with the right or the middle button, or with Shift, to move. The wheel zooms at the pointer. " +
  "W, A, S, D, Q and E move, the arrows turn. By touch: one finger turns, two zoom and move.";

interface SceneButtonsProps {
  readonly store: Store;
  readonly session: string;
  /** Tools: between the cameras and the layers, so that a narrow view has them at hand. */
  readonly children?: ComponentChildren;
}

export function SceneButtons({ store, session, children }: SceneButtonsProps) {
  const now = store.part("scene").message.value;
  const id = useId();
  if (!now) return null; // the tools as well: all appear at once, so that none moves when others appear
  const change = (wanted: SceneSettings): void => void changeScene(session, wanted);
  const cameras = now.cameras.map((camera) => ({
    camera,
    label: camera.charAt(0).toUpperCase() + camera.slice(1),
  }));
  return (
    <>
      <fieldset class="actions scene-cameras" aria-label="Camera">
        {cameras.map(({ camera, label }) => (
          <Button key={camera} onClick={() => change({ camera })}>
            {label}
          </Button>
        ))}
        <CameraMenu options={cameras} onChoose={(camera) => change({ camera })} />
        <Tooltip id={id} about="the gestures" text={GESTURES} />
      </fieldset>
      {children}
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

type Camera = NonNullable<SceneSettings["camera"]>;

interface CameraMenuProps {
  readonly options: readonly { readonly camera: Camera; readonly label: string }[];
  readonly onChoose: (camera: Camera) => void;
}

/** The cameras as a menu, instead of buttons, if the view is narrow. Each can be chosen again. */
function CameraMenu({ options, onChoose }: CameraMenuProps) {
  return (
    <select
      class="select scene-camera-menu"
      aria-label="Camera"
      value=""
      onChange={({ currentTarget }) => {
        const chosen = options.find(({ camera }) => camera === currentTarget.value);
        currentTarget.value = "";
        if (chosen) onChoose(chosen.camera);
      }}
    >
      <option value="" hidden>
        Camera
      </option>
      {options.map(({ camera, label }) => (
        <option key={camera} value={camera}>
          {label}
        </option>
      ))}
    </select>
  );
}
