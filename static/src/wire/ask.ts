/** Requests to the service, whose answers have the types that are generated from its routes. */

import type { Answers } from "./http";

/** The names in the braces of an address. */
type Names<A extends string> = A extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;

type Query = Readonly<Record<string, string | number | boolean | readonly string[]>>;

interface Options {
  readonly query?: Query;
  /** Sent as JSON. */
  readonly body?: unknown;
  /** Sent as it is. */
  readonly file?: BodyInit | undefined;
  /** Ends the request. */
  readonly ending?: AbortSignal | undefined;
}

export const NO_ANSWER = "The server does not answer.";

/** A request that was refused, or that the service did not answer; the message is a sentence for people. */
export class RequestError extends Error {
  constructor(
    message: string,
    /** The status of the answer; null where there was none. */
    readonly status: number | null,
  ) {
    super(message);
  }
}

const PASSING: readonly number[] = [408, 425, 429, 502, 503, 504];

/**
 * Whether a request of this status may succeed later: there were too many, there is no room or memory now, the server
 * begins again, or it did not answer (null).
 */
export const isPassing = (status: number | null): boolean => status === null || PASSING.includes(status);

/** Whether the same request may succeed later. */
export const mayPass = (error: unknown): boolean => error instanceof RequestError && isPassing(error.status);

/** What a page says that asks again by itself after an error. */
export const whyAgain = (error: unknown): string => `${(error as Error).message} The page tries again by itself.`;

/** The error message in an answer of the server, or a general one. */
async function refusalIn(answer: Response): Promise<string> {
  try {
    const body: unknown = await answer.json();
    if (body && typeof body === "object" && "message" in body && typeof body.message === "string") return body.message;
  } catch {
    // not JSON: for example the error page of a proxy
  }
  return `The server answered ${answer.status}.`;
}

/** Send a request, and return its answer. Rejects with a {@link RequestError} if it is refused. */
export async function fetched(address: string, options: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(address, options);
  } catch {
    throw new RequestError(NO_ANSWER, null);
  }
  if (!answer.ok) throw new RequestError(await refusalIn(answer), answer.status);
  return answer;
}

/** The address of a request, "GET /api/logs/{log_id}", with what it names and a query. */
export function addressOf<K extends string>(
  what: K,
  names: Readonly<Record<Names<K>, string | number>>,
  query: Query = {},
): string {
  const given: Readonly<Record<string, string | number>> = names;
  const path = what.slice(what.indexOf(" ") + 1);
  const address = path.replace(/\{(\w+)\}/g, (_, name: string) => encodeURIComponent(given[name] ?? ""));
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query))
    for (const item of Array.isArray(value) ? value : [value]) search.append(name, String(item));
  return search.size > 0 ? `${address}?${search}` : address;
}

/** Send a request to an address that {@link addressOf} has made, and return the answer. Rejects as {@link fetched}. */
export async function answerAt<K extends keyof Answers>(
  what: K,
  address: string,
  { body, file, ending }: Omit<Options, "query"> = {},
): Promise<Answers[K]> {
  const answer = await fetched(address, {
    method: what.slice(0, what.indexOf(" ")),
    ...(ending ? { signal: ending } : {}),
    ...(file === undefined ? {} : { body: file }),
    ...(body === undefined ? {} : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }),
  });
  return (answer.status === 204 ? undefined : await answer.json()) as Answers[K];
}

/** Send a request with what its address names, and return the answer. Rejects as {@link fetched}. */
export function ask<K extends keyof Answers>(
  what: K,
  names: Readonly<Record<Names<K>, string | number>>,
  { query, ...options }: Options = {},
): Promise<Answers[K]> {
  return answerAt(what, addressOf(what, names, query), options);
}
