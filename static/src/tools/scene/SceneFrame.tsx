/** The frame in which a session's scene is drawn in 3D, in the colours of the page. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { hasGraphicsCard } from "../../render/map/context";
import type { Store } from "../../store/store";
import { isDark, printing } from "../../ui/browser/theme";
import { toast } from "../../ui/Toast";
import { ask } from "../../wire/ask";
import type { SceneSettings, ShownCamera } from "../../wire/http";
import "./scene.css";

declare global {
  interface Window {
    /** Of the page of a 3D view: its camera; null if unknown. */
    sceneCamera?: () => ShownCamera | null;
  }
}

class First {
  camera: ShownCamera | null = null;
}

/** The initial camera of a session's 3D views; null: one that shows everything. */
export const firstOf = (store: Store): First => store.of(First);

const pathOf = (session: string): string => `/scenes/${encodeURIComponent(session)}/`;

/**
 * The address of a session's 3D view in this page, in the colours of the page. Without a graphics card its edges are not
 * smoothed, which halves the time of a frame.
 */
export function sceneAddress(session: string, store: Store, isDark: boolean): string {
  const { camera } = firstOf(store);
  const query = [
    ...(isDark ? ["darkMode"] : []),
    ...(hasGraphicsCard() ? [] : ["unsmoothed"]),
    ...(camera ? [`initialCameraPosition=${camera.position}`, `initialCameraLookAt=${camera.look_at}`] : []),
  ];
  return `${pathOf(session)}plain/${store.page}/${query.length > 0 ? `?${query.join("&")}` : ""}`;
}

/** The camera of a session's 3D view in this page; null if there is none. */
export function sceneCamera(session: string): ShownCamera | null {
  const view = document.querySelector<HTMLIFrameElement>(`iframe[src^="${pathOf(session)}"]`);
  return view?.contentWindow?.sceneCamera?.() ?? null;
}

/** The camera button of a session's 3D views that the visitor has chosen last; null: none yet. */
export const chosenCamera = async (session: string): Promise<NonNullable<SceneSettings["camera"]> | null> =>
  (await ask("GET /scenes/{session_id}/settings", { session_id: session })).camera;

/** Change some settings of the 3D view of a session. */
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

/** Shows that it is loading until the scene is shown, and again after a change of the colours or a lost connection. */
export function SceneFrame({ store, session, class: name, title }: SceneFrameProps) {
  const dark = useSignal(isDark.peek());
  const frame = useRef<HTMLIFrameElement>(null);
  const shown = useSignal(""); // the address of the page that shows its scene
  useSignalEffect(() => {
    if (!printing.value) dark.value = isDark.value;
  });
  const address = sceneAddress(session, store, dark.value);
  useLayoutEffect(() => {
    const view = frame.current;
    const onScene = (event: Event): void => {
      shown.value = (event as CustomEvent<boolean>).detail ? address : "";
    };
    view?.addEventListener("scene", onScene);
    return () => view?.removeEventListener("scene", onScene);
  }, [address]);
  const onLoad = (): void => {
    if (!frame.current?.contentWindow?.sceneCamera) shown.value = address; // another page, with a server's message
  };
  return (
    <>
      <iframe class={name} title={title} src={address} onLoad={onLoad} ref={frame} />
      {shown.value !== address && (
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
