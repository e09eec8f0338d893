/** The 3D view of a session: the canvas of the server's scene, and the page's controls of its camera and its layers. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { kept } from "../../ui/browser/kept";
import { isDark } from "../../ui/browser/theme";
import { Slider } from "../../ui/Slider";
import { MeasuringButtons, MeasuringIn3d } from "../measure/MapTools";
import { SceneButtons, savePicture } from "./SceneButtons";
import { changeScene, fullScreen, SceneFrame, sceneAddress } from "./SceneFrame";
import { useSelectedPlace } from "./selection";
import "./scene.css";

interface SceneProps {
  readonly store: Store;
  readonly session: string;
  /** Whether the map is drawn as columns, whose height can be set. */
  readonly hasColumns?: boolean;
  /** Further buttons below the picture. */
  readonly actions?: ComponentChildren;
  /** Text below the picture, in one line of a wide view and two of a narrow one. */
  readonly children?: ComponentChildren;
}

/** In a lower view the controls are folded until the user unfolds them, because they would take half of it, px. */
const LOW = 400;

/** Whether the controls are unfolded, by the last choice; null: if there is room for them. */
const unfolded = kept<boolean | null>(
  "gridbloom.3d.controls",
  null,
  (value): value is boolean | null => value === null || typeof value === "boolean",
);

export function Scene({ store, session, hasColumns = true, actions, children }: SceneProps) {
  const place = useRef<HTMLDivElement>(null);
  const group = useRef<HTMLDivElement>(null);
  const isLow = useSignal(false);
  useLayoutEffect(() => {
    isLow.value = (place.current?.parentElement?.clientHeight ?? LOW) < LOW;
  }, []);
  useEffect(() => {
    const free = (): void => {
      if (!document.fullscreenElement) place.current?.style.removeProperty("min-height");
    };
    document.addEventListener("fullscreenchange", free);
    return () => document.removeEventListener("fullscreenchange", free);
  }, []);
  useSelectedPlace(store);
  const enlarge = (): void => {
    if (!place.current || !group.current) return;
    // Its space in the panel is reserved, plus the amount by which the panel may grow, to avoid scrolling.
    const room = group.current.offsetHeight + Math.max(0, screen.height - innerHeight);
    if (!document.fullscreenElement) place.current.style.minHeight = `${room}px`;
    fullScreen(group.current);
  };
  return (
    <div class="scene-place" ref={place}>
      <div class="scene-group" ref={group}>
        <div class="scene-picture">
          <SceneFrame store={store} session={session} class="scene" title="3D view" />
        </div>
        {children}
        <SceneControls
          store={store}
          session={session}
          hasColumns={hasColumns}
          actions={actions}
          isUnfolded={unfolded.value ?? !isLow.value}
          onFullScreen={enlarge}
          onPicture={() => savePicture(group.current)}
        />
      </div>
    </div>
  );
}

interface SceneControlsProps extends Omit<SceneProps, "children"> {
  readonly isUnfolded: boolean;
  readonly onFullScreen: () => void;
  readonly onPicture: () => void;
}

function SceneControls({ store, isUnfolded, ...more }: SceneControlsProps) {
  const row = useRef<HTMLDivElement>(null);
  const isChosen = useRef(false);
  useLayoutEffect(() => {
    // The controls reduce the height of the picture and give it back, so the button must be scrolled into view.
    if (isChosen.current) row.current?.scrollIntoView({ block: "nearest" });
  }, [isUnfolded]);
  if (!store.part("scene").message.value) return null; // all of them appear at once, so that none moves
  return (
    <div class={`scene-controls stack-tight ${isUnfolded ? "" : "folded"}`.trim()}>
      <div class="actions" ref={row}>
        <MeasuringButtons store={store} />
        <Button
          icon={isUnfolded ? "unfold" : "up"}
          pressed={isUnfolded}
          onClick={() => {
            isChosen.current = true;
            unfolded.value = !isUnfolded;
          }}
        >
          Controls
        </Button>
      </div>
      <MeasuringIn3d store={store} snaps />
      {isUnfolded && <Unfolded store={store} {...more} />}
    </div>
  );
}

function Unfolded({
  store,
  session,
  hasColumns,
  actions,
  onFullScreen,
  onPicture,
}: Omit<SceneControlsProps, "isUnfolded">) {
  const now = store.part("scene").message.value;
  return (
    <>
      <SceneButtons store={store} session={session} />
      {hasColumns && now && (
        <Slider
          label="Height of the columns"
          sentence="Height of the map’s columns, relative to the default."
          unit="×"
          value={now.height}
          initial={1}
          low={0.2}
          high={5}
          step={0.1}
          onInput={(value) => void changeScene(session, { height: value })}
        />
      )}
      <div class="actions">
        {actions}
        <Button icon="fit" onClick={onFullScreen}>
          Full screen
        </Button>
        <Button icon="download" onClick={onPicture}>
          PNG
        </Button>
        <Button icon="cube" href={sceneAddress(session, store, isDark.value)} target="_blank">
          In a tab of its own
        </Button>
      </div>
    </>
  );
}
