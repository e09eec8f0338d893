/** Requests about SLAM of a log and about its pose graph. Each rejects with the server's sentence. */

import type { ScanPair } from "../../../store/sessionState";
import type { Candidate, Edge, Place, PoseGraph } from "../../../tools/heal/model";
import { request } from "../request";

/** SLAM of a log: what is under way, or what came of it. */
export interface SlamState {
  readonly state: "queued" | "running" | "done" | "failed" | "cancelled";
  readonly fraction: number;
  readonly stage: string | null;
  /** Scans whose poses are corrected. */
  readonly scans: number;
  readonly loops: number;
  readonly elapsed_s: number | null;
  /** Jobs that are begun before this one. */
  readonly ahead: number;
  readonly error: { readonly code: string; readonly message: string } | null;
  readonly result: {
    readonly trajectory: string;
    readonly odometry: string | null;
    readonly loops: number;
    readonly nodes: number;
    readonly cpu_s: number;
    readonly sharpness: readonly [number | null, number | null];
    readonly notes: readonly string[];
  } | null;
}

const session = (id: string): string => `/api/sessions/${encodeURIComponent(id)}`;
const slam = (log: string): string => `/api/logs/${encodeURIComponent(log)}/slam`;

export const heal = (id: string): Promise<SlamState> => request(`${session(id)}/heal`, "POST");

/** The newest SLAM of a log; null where there was none. */
export async function slamState(log: string): Promise<SlamState | null> {
  const answer = await fetch(slam(log));
  return answer.ok ? ((await answer.json()) as SlamState) : null;
}

export const cancelSlam = (log: string): Promise<SlamState> => request(slam(log), "DELETE");

export const poseGraph = (id: string): Promise<PoseGraph> => request(`${session(id)}/graph`);

export interface Change {
  readonly remove?: number;
  readonly lock?: number;
  readonly unlock?: number;
  readonly robust?: string;
  readonly robust_scale?: number;
  readonly reset?: boolean;
}

export const changeGraph = (id: string, change: Change): Promise<PoseGraph> =>
  request(`${session(id)}/graph`, "POST", change);

export const edgeOf = (id: string, edge: number): Promise<Edge> => request(`${session(id)}/graph/edges/${edge}`);

export const placeOf = (id: string, x: number, y: number): Promise<Place> =>
  request(`${session(id)}/graph/candidates?x=${x}&y=${y}`);

export const candidateOf = (id: string, candidate: number): Promise<Candidate & ScanPair> =>
  request(`${session(id)}/graph/candidates/${candidate}`);

export const keepGraph = (id: string): Promise<unknown> => request(`${session(id)}/graph/keep`, "POST");
