/** What can be set of the server's 3D views, as `/scenes/{session}/settings` has it. */

export interface SceneSettings {
  readonly cameras: readonly string[];
  readonly layers: Readonly<Record<string, boolean>>;
  readonly height: number;
}

export const sceneAddress = (session: string, part: string): string => `/scenes/${encodeURIComponent(session)}/${part}`;

/** The settings of a scene, after a change of some of them; null where the server does not answer. */
export async function askScene(session: string, wanted?: object): Promise<SceneSettings | null> {
  const change = wanted && {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(wanted),
  };
  try {
    const answer = await fetch(sceneAddress(session, "settings"), change);
    return answer.ok ? ((await answer.json()) as SceneSettings) : null;
  } catch {
    return null;
  }
}
