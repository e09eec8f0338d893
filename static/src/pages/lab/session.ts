import { createWorld } from "../worldSession";

/** Which session the lab shows, and what a person should know of how it came about. */
export interface Opened {
  readonly id: string;
  readonly notice: string | null;
}

const address = (id: string): string => `/lab.html?session=${encodeURIComponent(id)}`;

/** The session that the address names, or a new world, which the address then names. Throws where neither can be had. */
export async function openSession(): Promise<Opened> {
  const wanted = new URLSearchParams(location.search).get("session");
  let notice: string | null = null;
  if (wanted) {
    const answer = await fetch(`/api/sessions/${encodeURIComponent(wanted)}`);
    if (answer.ok) {
      const { kind } = (await answer.json()) as { kind?: string };
      if (kind === "log") location.replace(`/logs.html?session=${encodeURIComponent(wanted)}`);
      return { id: wanted, notice: null };
    }
    if (answer.status !== 404) throw new Error(`The server answered ${answer.status}; this page goes on trying.`);
    notice = "That world has ended: sessions close when nobody watches them. Here is a new one.";
  }
  const id = await createWorld();
  history.replaceState(null, "", address(id));
  return { id, notice };
}

/** The address that shows this very session to somebody else. */
export const shareAddress = (id: string): string => new URL(address(id), location.href).href;
