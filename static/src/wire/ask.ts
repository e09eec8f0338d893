/** Requests to the service: queries, bodies and answers have the types that are generated from its routes. */

import { awaited } from "../ui/browser/awaited";
import type { Answers, Bodies, Files, Queries } from "./http";

/** The names in the braces of an address. */
type Names<A extends string> = A extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;

/** A request, by method and address. */
type Asked = keyof Answers | Files;

/** The address with any text for each name in its braces. */
type Filled<A extends string> = A extends `${infer Begin}{${string}}${infer End}`
  ? `${Begin}${string}${Filled<End>}`
  : A;

/** A file of a session, by the part of the address that follows the session's. */
export type SessionFile = Files extends infer F
  ? F extends `GET /api/sessions/{session_id}/${infer Name}`
    ? Filled<Name>
    : never
  : never;

type Named<K extends string> = Readonly<Record<Names<K>, string | number>>;

interface Sent {
  /** Sent unchanged if it is a file, otherwise as JSON. */
  readonly body?: unknown;
  /** Cancels the request. */
  readonly ending?: AbortSignal | undefined;
}

type WithQuery<Q> = object extends Q ? { readonly query?: Q } : { readonly query: Q };

/** The arguments of a request in addition to the names in its address. */
type Options<K extends string> = Pick<Sent, "ending"> &
  (K extends keyof Queries ? WithQuery<Queries[K]> : unknown) &
  (K extends keyof Bodies ? { readonly body: Bodies[K] } : unknown);

/** {@link Options} as the last argument, which may be omitted if the request needs none. */
type Last<K extends string> = object extends Options<K> ? [options?: Options<K>] : [options: Options<K>];

export const NO_ANSWER = "The server does not answer.";

/** A request that was refused, or that the service did not answer. The message is a sentence for people. */
export class RequestError extends Error {
  constructor(
    message: string,
    /** The status of the answer; null without one. */
    readonly status: number | null,
  ) {
    super(message);
  }
}

const PASSING: readonly number[] = [408, 425, 429, 502, 503, 504];

/**
 * Whether a request with this status may succeed later: there were too many, there is no room or memory now, the server
 * is restarting, or it did not answer (null).
 */
export const isPassing = (status: number | null): boolean => status === null || PASSING.includes(status);

/** Whether the same request may succeed later. */
export const mayPass = (error: unknown): boolean => error instanceof RequestError && isPassing(error.status);

/** The message of a page that repeats a failed request automatically. */
export const whyAgain = (error: unknown): string => `${(error as Error).message} The page tries again by itself.`;

/** The error message in a refusal of the server, or a general one. */
export async function refusalIn(answer: Response): Promise<string> {
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
    answer = await awaited(fetch(address, options));
  } catch {
    throw new RequestError(NO_ANSWER, null);
  }
  if (!answer.ok) throw new RequestError(await refusalIn(answer), answer.status);
  return answer;
}

/** The answer in a response to a request that was not refused. */
export async function answerIn<K extends keyof Answers>(response: Response): Promise<Answers[K]> {
  const text = await response.text();
  const answers = text === "" ? [] : [JSON.parse(text)]; // there is none with status 204
  return answers[0];
}

/** The address of a request, "GET /api/logs/{log_id}", with its names and a query. */
export function addressOf<K extends Asked>(
  what: K,
  names: Named<K>,
  query?: K extends keyof Queries ? Queries[K] : never,
): string {
  const values: Readonly<Record<string, string | number>> = names;
  const path = what.slice(what.indexOf(" ") + 1);
  const address = path.replace(/\{(\w+)\}/g, (_, name: string) => encodeURIComponent(values[name] ?? ""));
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query ?? {}))
    for (const item of Array.isArray(value) ? value : [value]) search.append(name, String(item));
  return search.size > 0 ? `${address}?${search}` : address;
}

/** The address of the WebSocket at a path of the service. */
export const socketAddress = (path: string): string =>
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${path}`;

/** The address of a file of a session. */
export const fileAddress = (session: string, file: SessionFile): string =>
  `${addressOf("GET /api/sessions/{session_id}", { session_id: session })}/${file}`;

/** Send a request to an address from {@link addressOf}. Rejects like {@link fetched}. */
function send(what: string, address: string, { body, ending }: Sent): Promise<Response> {
  const isFile = body instanceof Blob;
  return fetched(address, {
    method: what.slice(0, what.indexOf(" ")),
    ...(ending ? { signal: ending } : {}),
    ...(isFile ? { body } : {}),
    ...(body === undefined || isFile
      ? {}
      : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }),
  });
}

/** Send a request to an address from {@link addressOf}, and return the answer. Rejects like {@link fetched}. */
export const answerAt = async <K extends keyof Answers>(
  what: K,
  address: string,
  ending?: AbortSignal,
): Promise<Answers[K]> => answerIn<K>(await send(what, address, { ending }));

/** Send a request with the names in its address, and return the response: a file. Rejects like {@link fetched}. */
export function fileOf<K extends Asked>(what: K, names: Named<K>, ...[options]: Last<K>): Promise<Response> {
  const { query, ...sent }: Sent & { readonly query?: never } = options ?? {};
  return send(what, addressOf(what, names, query), sent);
}

/** Send a request with the names in its address, and return the answer. Rejects like {@link fetched}. */
export const ask = async <K extends keyof Answers>(what: K, names: Named<K>, ...last: Last<K>): Promise<Answers[K]> =>
  answerIn<K>(await fileOf(what, names, ...last));
