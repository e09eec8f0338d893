/** Requests about SLAM of a log and about its pose graph. Each rejects with the server's sentence. */

import type { ScanPair } from "../../../store/sessionSignals";
import type { LoopHill } from "../../../tools/heal/hill";
import type { Candidate, Edge, Place, PoseGraph } from "../../../tools/heal/model";
import type { Parameter, Values } from "../../../wire/protocol";
import { request } from "../request";

/** SLAM of a log: its progress or its result. */
export interface SlamState {
  readonly state: "none" | "queued" | "running" | "done" | "failed" | "cancelled";
  readonly fraction: number;
  readonly stage: string | null;
  /** Scans whose poses are corrected. */
  readonly scans: number;
  readonly loops: number;
  readonly elapsed_s: number | null;
  /** Jobs that are begun before this one. */
  readonly ahead: number;
  /** Parameters that differ from the first values. */
  readonly parameters: Values;
  readonly error: { readonly code: string; readonly message: string } | null;
  readonly result: {
    readonly trajectory: string;
    readonly odometry: string | null;
    readonly loops: number;
    readonly nodes: number;
    readonly cpu_s: number;
    /** Of the map, before and after: metres, share, 0 … 1. A result that was kept by an older service has only the last. */
    readonly drift_m?: readonly [number | null, number | null];
    readonly contradicted?: readonly [number | null, number | null];
    readonly sharpness: readonly [number | null, number | null];
    readonly notes: readonly string[];
  } | null;
}

const session = (id: string): string => `/api/sessions/${encodeURIComponent(id)}`;
const healing = (id: string): string => `${session(id)}/heal`;

export const heal = (id: string, parameters: Values): Promise<SlamState> =>
  request(healing(id), "POST", { parameters });

export const slamParameters = async (): Promise<readonly Parameter[]> =>
  (await request<{ table: readonly Parameter[] }>("/api/slam/parameters")).table;

export const slamState = (id: string): Promise<SlamState> => request(healing(id));

export const cancelSlam = (id: string): Promise<SlamState> => request(healing(id), "DELETE");

/** The graph of the trajectory in use; null where it has none. */
export const poseGraph = async (id: string): Promise<PoseGraph | null> =>
  (await request<{ graph: PoseGraph | null }>(`${session(id)}/graph`)).graph;

/** The merge of two logs of one place: its progress or its result. */
export interface MergeState {
  readonly state: "none" | "queued" | "running" | "done" | "failed" | "cancelled";
  readonly other: string | null;
  readonly fraction: number;
  /** What is done now: "first log", "second log", "maps", "loops", "refinement" or "writing". */
  readonly stage: string | null;
  readonly elapsed_s: number | null;
  readonly error: { readonly message: string } | null;
  readonly result: {
    readonly trajectory: string;
    /** The log of both: its id, its name, and its sensors where they are several. */
    readonly log: string;
    readonly name: string;
    readonly topic: string | null;
    /** Whether a clock was set in it; empty where none was. */
    readonly note: string;
    readonly loops: number;
    readonly tried: number;
    readonly score: number;
    readonly cpu_s: number;
  } | null;
}

const merging = (id: string): string => `${session(id)}/merge`;

export const mergeState = (id: string): Promise<MergeState> => request(merging(id));

export const mergeWith = (id: string, log: string, topic: string | null): Promise<MergeState> =>
  request(merging(id), "POST", { log, topic });

export const cancelMerge = (id: string): Promise<MergeState> => request(merging(id), "DELETE");

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
