/** What can be set of the server's 3D views; the message `scene` has what is set. */

import type { Store } from "../../store/store";
import { toast } from "../../ui/Toast";
import { ask } from "../../wire/ask";
import type { SceneSettings } from "../../wire/http";

/** The address of a session's 3D view in this page, in the colours of the page. */
export const sceneAddress = (session: string, { page }: Store, isDark: boolean): string =>
  `/scenes/${encodeURIComponent(session)}/plain/${page}/${isDark ? "?darkMode" : ""}`;

/** Change some settings of a session's 3D view. */
export async function changeScene(session: string, body: SceneSettings): Promise<void> {
  try {
    await ask("POST /scenes/{session_id}/settings", { session_id: session }, { body });
  } catch {
    toast("The server does not answer.", "error");
  }
}
