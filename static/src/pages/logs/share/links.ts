/** Shared links: they open a read-only view of a log until they are revoked. */

import type { SharedView } from "../../../render/view";
import { reducedMotion } from "../../../ui/browser/media";
import { ask } from "../../../wire/ask";
import type { LinkAnswer as Link, SessionAnswer, SharedAnswer, Shown } from "../../../wire/http";
import { followMaking, newName } from "../../making";
import { trajectoryLabel } from "../library/describeLog";
import { opening } from "../library/library";

export type { Link, Shown };

/** Create a link to the current view of a session. This and the other requests reject with an error message. */
export const makeLink = (session: string, look: SharedView | null, shown: Shown | null = null): Promise<Link> =>
  ask("POST /api/sessions/{session_id}/links", { session_id: session }, { body: { look, shown } });

/** The links to a session's log that its visitor has made, newest first. */
export const linksOf = async (session: string): Promise<readonly Link[]> =>
  (await ask("GET /api/sessions/{session_id}/links", { session_id: session })).links;

export const revokeLink = (session: string, token: string): Promise<void> =>
  ask("DELETE /api/sessions/{session_id}/links/{token}", { session_id: session, token });

/** The token in the path of a shared link; null for another path. */
export const linkOf = (path: string): string | null => /^\/shared\/([\w-]+)\/?$/.exec(path)?.[1] ?? null;

export const shared = (token: string): Promise<SharedAnswer> => ask("GET /api/shared/{token}", { token });

/**
 * Open a separate session on the view of a link, or on the point clouds of its log. `ending` aborts the request. With
 * reduced motion, a log that would play from its start is shown complete.
 */
export async function beginShared(token: string, ending: AbortSignal, clouds = false): Promise<SessionAnswer> {
  const name = newName();
  const stop = followMaking(name, (making) => {
    opening.value = making;
  });
  try {
    const query = { name, whole: reducedMotion.peek(), clouds };
    return await ask("POST /api/shared/{token}/sessions", { token }, { query, ending });
  } finally {
    stop();
  }
}

const counted = (n: number, single: string, more: string): string => (n === 1 ? `1 ${single}` : `${n} ${more}`);

const scansOf = (index: number, count: number): string =>
  index === count ? "the whole log" : `${index} of ${count} scans`;

/** The view of a link in one line; `unit` is the unit of the log's sequence. */
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
