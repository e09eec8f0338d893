/** What can be set of the server's 3D views, as `/scenes/{session}/settings` has it. */

import { ask } from "../../wire/ask";
import type { SceneAnswer } from "../../wire/http";

export const sceneAddress = (session: string, part: string): string => `/scenes/${encodeURIComponent(session)}/${part}`;

/** The settings of a scene, after a change of some of them; null where the server does not answer. */
export function askScene(session: string, wanted?: object): Promise<SceneAnswer | null> {
  const names = { session_id: session };
  const answer = wanted
    ? ask("POST /scenes/{session_id}/settings", names, { body: wanted })
    : ask("GET /scenes/{session_id}/settings", names);
  return answer.catch(() => null);
}
