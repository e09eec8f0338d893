import type { Work } from "../ui/Working";

/** A request that takes longer shows its progress. */
const SHOWN_AFTER_MS = 300;
const POLL_MS = 250;

/** The progress of a session that the server makes. */
export interface Making extends Work {
  /** What the server does; null: what was asked for. */
  readonly what: string | null;
}

/** A random name for a session that is requested. */
export const newName = (): string =>
  Array.from(crypto.getRandomValues(new Uint32Array(3)), (n) => n.toString(36)).join("");

/** Show the progress of the session that was requested by a name, until the returned function is called. */
export function followMaking(name: string, show: (making: Making | null) => void): () => void {
  const ending = new AbortController();
  const poll = async (): Promise<void> => {
    try {
      const answer = await fetch(`/api/sessions/making/${name}`, { signal: ending.signal });
      if (answer.status === 200) show((await answer.json()) as Making);
    } catch {
      // The request for the session itself reports that the server does not answer.
    }
    if (ending.signal.aborted) show(null);
    else timer = setTimeout(() => void poll(), POLL_MS);
  };
  let timer = setTimeout(() => void poll(), SHOWN_AFTER_MS);
  return () => {
    ending.abort();
    clearTimeout(timer);
    show(null);
  };
}
