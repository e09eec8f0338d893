/** Requests about SLAM of a log and about its pose graph. Each rejects with the server's sentence. */

import type { ScanPair } from "../../../store/sessionSignals";
import type { LoopHill } from "../../../tools/heal/hill";
import type { Candidate, Edge, Place, PoseGraph } from "../../../tools/heal/model";
import type { MergeStatus, SlamStatus } from "../../../wire/http";
import type { Parameter, Values } from "../../../wire/protocol";
import { ask, request } from "../request";

export type { MergeStatus, SlamStatus };

const session = (id: string): string => `/api/sessions/${encodeURIComponent(id)}`;

export const heal = (id: string, parameters: Values): Promise<SlamStatus> =>
  ask("POST /api/sessions/{session_id}/heal", { session_id: id }, { body: { parameters } });

export const slamParameters = async (): Promise<readonly Parameter[]> =>
  (await request<{ table: readonly Parameter[] }>("/api/slam/parameters")).table;

export const slamState = (id: string): Promise<SlamStatus> =>
  ask("GET /api/sessions/{session_id}/heal", { session_id: id });

export const cancelSlam = (id: string): Promise<SlamStatus> =>
  ask("DELETE /api/sessions/{session_id}/heal", { session_id: id });

/** The graph of the trajectory in use; null where it has none. */
export const poseGraph = async (id: string): Promise<PoseGraph | null> =>
  (await request<{ graph: PoseGraph | null }>(`${session(id)}/graph`)).graph;

export const mergeState = (id: string): Promise<MergeStatus> =>
  ask("GET /api/sessions/{session_id}/merge", { session_id: id });

export const mergeWith = (id: string, log: string, topic: string | null): Promise<MergeStatus> =>
  ask("POST /api/sessions/{session_id}/merge", { session_id: id }, { body: { log, topic } });

export const cancelMerge = (id: string): Promise<MergeStatus> =>
  ask("DELETE /api/sessions/{session_id}/merge", { session_id: id });

/** Mean errors over relations. */
export interface ScoreFigures {
  readonly count: number;
  readonly translation_m: number;
  readonly rotation_deg: number;
}

export interface PoseScore {
  readonly trajectory: string;
  readonly relations: number;
  readonly policy: "records" | "time";
  readonly left_out: number;
  readonly all: ScoreFigures;
  readonly unambiguous: ScoreFigures | null;
  readonly published: readonly {
    readonly program: string;
    readonly translation: number;
    readonly rotation: number | null;
    readonly count: number | null;
    readonly source: string;
  }[];
}

/** Score the poses in use against the relations in a file. */
export async function scorePoses(id: string, file: File): Promise<PoseScore> {
  const answer = await fetch(`${session(id)}/relations?name=${encodeURIComponent(file.name)}`, {
    method: "PUT",
    body: file,
  });
  const body = (await answer.json()) as PoseScore & { readonly message?: string };
  if (!answer.ok) throw new Error(body.message ?? "The server refused this file.");
  return body;
}

export interface Change {
  readonly remove?: number;
  readonly lock?: number;
  readonly unlock?: number;
  /** Two scans to be joined by a loop. */
  readonly add?: readonly [number, number];
  readonly robust?: string;
  readonly robust_scale?: number;
  readonly reset?: boolean;
}

export const changeGraph = async (id: string, change: Change): Promise<PoseGraph> =>
  (await request<{ graph: PoseGraph }>(`${session(id)}/graph`, "POST", change)).graph;

export const edgeOf = (id: string, edge: number): Promise<Edge> => request(`${session(id)}/graph/edges/${edge}`);

export const hillOf = (id: string, edge: number): Promise<LoopHill> =>
  request(`${session(id)}/graph/edges/${edge}/hill`);

export const placeOf = (id: string, x: number, y: number): Promise<Place> =>
  request(`${session(id)}/graph/candidates?x=${x}&y=${y}`);

export const candidateOf = (id: string, candidate: number): Promise<Candidate & ScanPair> =>
  request(`${session(id)}/graph/candidates/${candidate}`);

export const keepGraph = (id: string): Promise<unknown> => request(`${session(id)}/graph/keep`, "POST");
