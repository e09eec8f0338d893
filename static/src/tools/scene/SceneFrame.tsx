/** The frame in which a session's scene is drawn in 3D, in the colours of the page. */

import { useSignal, useSignalEffect } from "@preact/signals";
import type { Store } from "../../store/store";
import { isDark, printing } from "../../ui/browser/theme";
import { toast } from "../../ui/Toast";
import { ask } from "../../wire/ask";
import type { SceneSettings } from "../../wire/http";
import "./scene.css";

/** The address of a session's 3D view in this page, in the colours of the page. */
const sceneAddress = (session: string, { page }: Store, isDark: boolean): string =>
  `/scenes/${encodeURIComponent(session)}/plain/${page}/${isDark ? "?darkMode" : ""}`;

/** Change some settings of a session's 3D view. */
export async function changeScene(session: string, body: SceneSettings): Promise<void> {
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
