/** Requests about SLAM of a log and about its pose graph. Each rejects with the server's sentence. */

import { ask } from "../../../wire/ask";
import type {
  ChangeOfGraph,
  EdgeAnswer,
  MergeStatus,
  PoseGraphAnswer,
  PoseScore,
  ScanConstraints,
  ScoreLandscape,
  SlamStatus,
  TriedLoopScans,
  TriedNear,
} from "../../../wire/http";
import type { Parameter, Values } from "../../../wire/protocol";

export type { MergeStatus, PoseScore, SlamStatus };

export const correctPoses = (id: string, parameters: Values): Promise<SlamStatus> =>
  ask("POST /api/sessions/{session_id}/heal", { session_id: id }, { body: { parameters } });

export const slamParameters = async (): Promise<readonly Parameter[]> =>
  (await ask("GET /api/slam/parameters", {})).table;

export const slamState = (id: string): Promise<SlamStatus> =>
  ask("GET /api/sessions/{session_id}/heal", { session_id: id });

export const cancelSlam = (id: string): Promise<SlamStatus> =>
  ask("DELETE /api/sessions/{session_id}/heal", { session_id: id });

/** The graph of the trajectory in use; null if it has none. */
export const poseGraph = async (id: string): Promise<PoseGraphAnswer | null> =>
  (await ask("GET /api/sessions/{session_id}/graph", { session_id: id })).graph;

export const mergeState = (id: string): Promise<MergeStatus> =>
  ask("GET /api/sessions/{session_id}/merge", { session_id: id });

export const mergeWith = (id: string, log: string, topic: string | null): Promise<MergeStatus> =>
  ask("POST /api/sessions/{session_id}/merge", { session_id: id }, { body: { log, topic } });

export const cancelMerge = (id: string): Promise<MergeStatus> =>
  ask("DELETE /api/sessions/{session_id}/merge", { session_id: id });

/** Score the poses in use against the relations in a file. */
export const scorePoses = (id: string, file: File): Promise<PoseScore> =>
  ask("PUT /api/sessions/{session_id}/relations", { session_id: id }, { query: { name: file.name }, body: file });

export const changeGraph = async (id: string, body: ChangeOfGraph): Promise<PoseGraphAnswer | null> =>
  (await ask("POST /api/sessions/{session_id}/graph", { session_id: id }, { body })).graph;

export const edgeOf = (id: string, edge: number): Promise<EdgeAnswer> =>
  ask("GET /api/sessions/{session_id}/graph/edges/{edge}", { session_id: id, edge });

/** The edges that determine the pose of a scan, from 0; null if the poses have no graph. */
export async function constraintsOf(id: string, scan: number): Promise<ScanConstraints | null> {
  try {
    return await ask("GET /api/sessions/{session_id}/graph/scans/{scan}", { session_id: id, scan });
  } catch {
    return null;
  }
}

export const landscapeOf = (id: string, edge: number): Promise<ScoreLandscape> =>
  ask("GET /api/sessions/{session_id}/graph/edges/{edge}/landscape", { session_id: id, edge });

export const placeOf = (id: string, x: number, y: number): Promise<TriedNear> =>
  ask("GET /api/sessions/{session_id}/graph/candidates", { session_id: id }, { query: { x, y } });

export const candidateOf = (id: string, candidate: number): Promise<TriedLoopScans> =>
  ask("GET /api/sessions/{session_id}/graph/candidates/{candidate}", { session_id: id, candidate });

export const keepGraph = (id: string): Promise<unknown> =>
  ask("POST /api/sessions/{session_id}/graph/keep", { session_id: id });
