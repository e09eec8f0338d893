/** Links that open a view of a log, read-only, until they are revoked. */

import type { Look } from "../../render/view";
import { trajectoryLabel } from "./describeLog";
import { AWAY, sentence } from "./library";

/** A link as the one who made it sees it. */
export interface Link {
  readonly token: string;
  readonly address: string;
  /** Seconds since 1970. */
  readonly created_s: number;
  readonly log: string;
  readonly topic: string | null;
  readonly trajectory: string;
  /** Scans in the map, of all. */
  readonly index: number;
  readonly count: number;
  /** Names of the parameters that are not as they are at first. */
  readonly changed: readonly string[];
  /** How many views are open by it. */
  readonly watching: number;
}

/** What a link opens, as anybody who has it sees it. */
export interface Shared {
  readonly title: string;
  /** What part of the map; null for all of it. */
  readonly look: Look | null;
}

async function asked<T>(address: string, method = "GET", body?: unknown): Promise<T> {
  let answer: Response;
  try {
    answer = await fetch(address, {
      method,
      ...(body === undefined ? {} : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }),
    });
  } catch {
    throw new Error(AWAY);
  }
  if (!answer.ok) throw new Error(await sentence(answer));
  return (answer.status === 204 ? undefined : await answer.json()) as T;
}

/** Make a link to what a session shows now. This and the others reject with a sentence. */
export const makeLink = (session: string, look: Look | null): Promise<Link> =>
  asked("/api/links", "POST", { session, look });

/** One's own links to a log, the newest first. */
export const linksTo = async (log: string): Promise<readonly Link[]> =>
  (await asked<{ links: readonly Link[] }>(`/api/links?log=${encodeURIComponent(log)}`)).links;

export const revokeLink = (token: string): Promise<void> => asked(`/api/links/${encodeURIComponent(token)}`, "DELETE");

/** The link of a page's address; null where it is none. */
export const linkOf = (path: string): string | null => /^\/shared\/([\w-]+)\/?$/.exec(path)?.[1] ?? null;

export const shared = (token: string): Promise<Shared> => asked(`/api/shared/${token}`);

/** Begin a session of one's own of what a link opens; resolves to its id. */
export const beginShared = async (token: string): Promise<string> =>
  (await asked<{ id: string }>(`/api/shared/${token}/sessions`, "POST")).id;

const counted = (n: number, one: string, more: string): string => (n === 1 ? `1 ${one}` : `${n} ${more}`);

/** Which view a link opens, in a line. */
export function described(link: Link): string {
  const { index, count, changed, topic, trajectory, watching } = link;
  return [
    index === count ? "the whole log" : `${index} of ${count} scans`,
    trajectoryLabel(trajectory),
    ...(topic === null ? [] : [topic]),
    ...(changed.length === 0 ? [] : [counted(changed.length, "changed parameter", "changed parameters")]),
    ...(watching === 0 ? [] : [`${counted(watching, "viewer", "viewers")} now`]),
  ].join(" · ");
}
