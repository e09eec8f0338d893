import { ask } from "../wire/ask";
import type { MakingAnswer as Making } from "../wire/http";

export type { Making };

/** A request that takes longer shows its progress. */
const SHOWN_AFTER_MS = 300;
const POLL_MS = 250;

/** A random name for a session that is requested. */
export const newName = (): string =>
  Array.from(crypto.getRandomValues(new Uint32Array(3)), (n) => n.toString(36)).join("");

/** Show the progress of the session that was requested by a name, until the returned function is called. */
export function followMaking(name: string, show: (making: Making | null) => void): () => void {
  const ending = new AbortController();
  const poll = async (): Promise<void> => {
    try {
      const making = await ask("GET /api/sessions/making/{name}", { name }, { ending: ending.signal });
      if (making) show(making);
    } catch {
      // The request for the session itself reports a server that does not answer.
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
