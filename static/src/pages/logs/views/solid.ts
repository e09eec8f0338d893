/** The content of the 3D view on a log's stage, and its state in a link. */

import { effect, type Signal, signal } from "@preact/signals";
import type { Store } from "../../../store/store";
import { changeScene, chosenCamera, firstOf, sceneCamera } from "../../../tools/scene/SceneFrame";
import { lookOf } from "../../../tools/volume/useLook";
import type { SessionAnswer, ShownScene } from "../../../wire/http";
import type { ContentsState } from "../contents/useContents";
import { isCloud } from "../library/describeLog";

interface SceneOf {
  readonly session: string;
  readonly store: Store;
}

/** Whether a recording is known to have point clouds, from which a 3D map can be made. */
export const hasClouds = (contents: ContentsState): boolean =>
  contents.kind === "ready" && contents.contents.topics.some(({ type, messages }) => isCloud(type) && messages > 0);

export class Solid {
  /** Whether it shows the log's point clouds, which have a separate session, instead of the map. */
  readonly clouds: Signal<boolean>;
  /** Start a session on the point clouds. */
  readonly open: (ending: AbortSignal) => Promise<SessionAnswer>;
  readonly #map: SceneOf;
  #shown: SceneOf;
  #given: ShownScene | null;

  /** `given` is the state in a link. */
  constructor(map: SceneOf, given: ShownScene | null, open: Solid["open"]) {
    this.clouds = signal(given?.clouds ?? false);
    this.open = open;
    this.#map = this.#shown = map;
    this.#given = given;
    if (given && !given.clouds) firstOf(map.store).camera = given.camera;
  }

  /** The map is shown: the view starts in the state of the link. The returned function stops waiting for the view. */
  beginMap(): () => void {
    return this.#given?.clouds === false ? this.#begin(this.#map) : () => undefined;
  }

  /** The same for the point clouds. The returned function reports that they are no longer shown. */
  beginClouds(clouds: SceneOf): () => void {
    this.#shown = clouds;
    if (this.#given?.clouds) firstOf(clouds.store).camera = this.#given.camera;
    const stop = this.#given?.clouds ? this.#begin(clouds) : undefined;
    return () => {
      stop?.();
      this.#shown = this.#map;
    };
  }

  #begin({ session, store }: SceneOf): () => void {
    const given = this.#given;
    this.#given = null;
    let isDone = false;
    return effect(() => {
      if (isDone || !given || !store.part("scene").message.value) return;
      isDone = true;
      if (Object.keys(given.look).length > 0) store.sendSoon({ type: "volume_look", values: given.look });
      void changeScene(session, { layers: given.layers, height: given.height, camera: given.chosen });
    });
  }

  /** The state for a link; null if no 3D view was opened. */
  async shown(): Promise<ShownScene | null> {
    const { session, store } = this.#shown;
    const now = store.part("scene").message.peek();
    if (!now) return null;
    const clouds = this.#shown !== this.#map;
    const camera = sceneCamera(session);
    const chosen = await chosenCamera(session);
    const isFollowing = chosen === "follow" || chosen === "first person";
    return {
      clouds,
      chosen: camera && !isFollowing ? null : chosen,
      look: clouds ? lookOf(store).values.peek() : {},
      camera,
      layers: now.layers,
      height: now.height,
    };
  }
}
