/** Requests to the service. */

import { AWAY, sentence } from "./library/library";

/** Send a request, and return the JSON of the answer. Rejects with the server's sentence if it is refused. */
export async function request<T>(address: string, method = "GET", body?: unknown, ending?: AbortSignal): Promise<T> {
  let answer: Response;
  try {
    answer = await fetch(address, {
      method,
      ...(ending ? { signal: ending } : {}),
      ...(body === undefined ? {} : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }),
    });
  } catch {
    throw new Error(AWAY);
  }
  if (!answer.ok) throw new Error(await sentence(answer));
  return (answer.status === 204 ? undefined : await answer.json()) as T;
}
