/** Requests to the service. */

import type { Answers } from "../../wire/http";
import { AWAY, sentence } from "./library/library";

/** The names in the braces of an address. */
type Names<A extends string> = A extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;

interface Options {
  readonly query?: Readonly<Record<string, string | number>>;
  readonly body?: unknown;
  /** Ends the request. */
  readonly ending?: AbortSignal;
}

/**
 * Send a request whose answer is a model of the service, "GET /api/logs/{log_id}", with what its address names. Rejects
 * with the server's sentence if it is refused.
 */
export function ask<K extends keyof Answers>(
  what: K,
  names: Readonly<Record<Names<K>, string | number>>,
  { query, body, ending }: Options = {},
): Promise<Answers[K]> {
  const [method, path] = what.split(" ", 2) as [string, string];
  const given: Readonly<Record<string, string | number>> = names;
  const address = path.replace(/\{(\w+)\}/g, (_, name: string) => encodeURIComponent(given[name] ?? ""));
  const more = query
    ? `?${new URLSearchParams(Object.entries(query).map(([name, value]) => [name, String(value)]))}`
    : "";
  return request(address + more, method, body, ending);
}

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
