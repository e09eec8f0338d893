/** The frame in which a session's scene is drawn in 3D, in the colours of the page. */

import { useSignal, useSignalEffect } from "@preact/signals";
import type { Store } from "../../store/store";
import { isDark, printing } from "../../ui/browser/theme";
import { toast } from "../../ui/Toast";
import { ask } from "../../wire/ask";
import type { SceneSettings, ShownCamera } from "../../wire/http";
import "./scene.css";

declare global {
  interface Window {
    /** Of the page of a 3D view: from where it is seen; null if that is not known. */
    sceneCamera?: () => ShownCamera | null;
  }
}

class First {
  camera: ShownCamera | null = null;
  /** The camera that was chosen last by a button; null: none yet. */
  chosen: NonNullable<SceneSettings["camera"]> | null = null;
}

/** From where the 3D views of a session are seen at first; null: from where all of it is in sight. */
export const firstOf = (store: Store): First => store.of(First);

const pathOf = (session: string): string => `/scenes/${encodeURIComponent(session)}/`;

/** The address of a session's 3D view in this page, in the colours of the page. */
export function sceneAddress(session: string, store: Store, isDark: boolean): string {
  const { camera } = firstOf(store);
  const query = [
    ...(isDark ? ["darkMode"] : []),
    ...(camera ? [`initialCameraPosition=${camera.position}`, `initialCameraLookAt=${camera.look_at}`] : []),
  ];
  return `${pathOf(session)}plain/${store.page}/${query.length > 0 ? `?${query.join("&")}` : ""}`;
}

/** From where a session's 3D view in this page is seen; null where there is none. */
export function sceneCamera(session: string): ShownCamera | null {
  const view = document.querySelector<HTMLIFrameElement>(`iframe[src^="${pathOf(session)}"]`);
  return view?.contentWindow?.sceneCamera?.() ?? null;
}

/** Change some settings of the 3D view of a session, whose store is `store`. */
export async function changeScene(session: string, store: Store, body: SceneSettings): Promise<void> {
  if (body.camera) firstOf(store).chosen = body.camera;
  try {
    await ask("POST /scenes/{session_id}/settings", { session_id: session }, { body });
  } catch {
    toast("The server does not answer.", "error");
  }
}

interface SceneFrameProps {
  readonly store: Store;
  readonly session: string;
  readonly class: string;
  readonly title: string;
}

/** Says that it loads until it has loaded, and again after a change of the colours. */
export function SceneFrame({ store, session, class: name, title }: SceneFrameProps) {
  const dark = useSignal(isDark.peek());
  const loaded = useSignal("");
  useSignalEffect(() => {
    if (!printing.value) dark.value = isDark.value;
  });
  const address = sceneAddress(session, store, dark.value);
  const onLoad = (): void => {
    loaded.value = address;
  };
  return (
    <>
      <iframe class={name} title={title} src={address} onLoad={onLoad} />
      {loaded.value !== address && (
        <p class="scene-loading" role="status">
          Loading the 3D view
        </p>
      )}
    </>
  );
}

/** Show an element on the whole screen, or in the page again. */
export function fullScreen(element: Element | null): void {
  const change = document.fullscreenElement ? document.exitFullscreen() : element?.requestFullscreen?.();
  (change ?? Promise.reject()).catch(() => toast("The browser does not allow the full screen here.", "error"));
}
