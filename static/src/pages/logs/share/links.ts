/** Shared links: they open a read-only view of a log until they are revoked. */

import type { SharedView } from "../../../render/view";
import { reducedMotion } from "../../../ui/browser/reducedMotion";
import type { LinkAnswer as Link } from "../../../wire/http";
import { followMaking, newName } from "../../making";
import { trajectoryLabel } from "../library/describeLog";
import { opening } from "../library/library";
import { ask, request } from "../request";

export type { Link };

/** What else than a part of the map its sender saw. */
export interface Shown {
  readonly group: string | null;
  readonly note: string | null;
  readonly layout: string | null;
}

/** A link as everyone who has it sees it. */
export interface Shared {
  readonly title: string;
  /** The visible part of the map; null for all of it. */
  readonly look: SharedView | null;
  /** Null of a link that tells nothing of it. */
  readonly shown: Shown | null;
}

/** Create a link to the current view of a session. This and the other requests reject with an error message. */
export const makeLink = (session: string, look: SharedView | null, shown: Shown | null = null): Promise<Link> =>
  ask("POST /api/links", {}, { body: { session, look, shown } });

const linksAddress = (session: string): string => `/api/sessions/${encodeURIComponent(session)}/links`;

/** The links to the log of a session that its visitor has made, the newest first. */
export const linksOf = async (session: string): Promise<readonly Link[]> =>
  (await ask("GET /api/sessions/{session_id}/links", { session_id: session })).links;

export const revokeLink = (session: string, token: string): Promise<void> =>
  request(`${linksAddress(session)}/${encodeURIComponent(token)}`, "DELETE");

/** The token in the path of a shared link; null for another path. */
export const linkOf = (path: string): string | null => /^\/shared\/([\w-]+)\/?$/.exec(path)?.[1] ?? null;

export const shared = (token: string): Promise<Shared> => request(`/api/shared/${token}`);

/** A session that shows the view of a link. */
export interface SharedSession {
  readonly id: string;
  /** "log", or "costmaps" for recorded costmaps. */
  readonly kind: string;
}

/**
 * Open a separate session on the view of a link. `ending` ends the request. With reduced motion a log that would play
 * from its start is shown whole.
 */
export async function beginShared(token: string, ending: AbortSignal): Promise<SharedSession> {
  const name = newName();
  const stop = followMaking(name, (making) => {
    opening.value = making;
  });
  try {
    const at = `/api/shared/${token}/sessions?name=${name}&whole=${reducedMotion.peek()}`;
    return await request<SharedSession>(at, "POST", undefined, ending);
  } finally {
    stop();
  }
}

const counted = (n: number, one: string, more: string): string => (n === 1 ? `1 ${one}` : `${n} ${more}`);

const scansOf = (index: number, count: number): string =>
  index === count ? "the whole log" : `${index} of ${count} scans`;

/** The view of a link in one line; `unit` is what its log shows one after the other. */
export function described(link: Link, unit: "scan" | "costmap" = "scan"): string {
  const { index, count, changed, topic, trajectory, watching } = link;
  return [
    unit === "costmap" ? `costmap ${index} of ${count}` : scansOf(index, count),
    ...(trajectory === null ? [] : [trajectoryLabel(trajectory)]),
    ...(topic === null ? [] : [topic]),
    ...(changed.length === 0 ? [] : [counted(changed.length, "changed parameter", "changed parameters")]),
    ...(watching === 0 ? [] : [`${counted(watching, "viewer", "viewers")} now`]),
  ].join(" · ");
}
