/** Requests about the localization of a log in a map. Each rejects with the server's sentence. */

import type { LocalizationStatus } from "../../../wire/http";
import type { Pose, Values } from "../../../wire/protocol";
import { AWAY, sentence } from "../library/library";
import { tarred } from "../library/tar";
import { ask, request } from "../request";

export type { LocalizationStatus };

/** The map that a log is localized in. */
export interface GivenMap {
  readonly title: string;
  readonly rows: number;
  readonly cols: number;
  /** Metres a cell. */
  readonly resolution: number;
  readonly origin: Pose;
  readonly notes: readonly string[];
}

/** How certain the poses in use are along the log. */
export interface Course {
  readonly map: GivenMap;
  readonly scans: readonly number[];
  readonly seconds: readonly number[];
  readonly entropy: readonly number[];
  readonly deviation_m: readonly number[];
  readonly fit: readonly number[];
  readonly is_converged: readonly boolean[];
  readonly n_particles: readonly number[];
  readonly first_converged: number | null;
}

const of = (session: string): string => `/api/sessions/${encodeURIComponent(session)}/localization`;

export const localizationState = (session: string): Promise<LocalizationStatus> =>
  ask("GET /api/sessions/{session_id}/localization", { session_id: session });

export const localize = (
  session: string,
  wanted: { readonly initial_pose: Pose | null; readonly odometry: string | null; readonly parameters: Values },
): Promise<LocalizationStatus> =>
  ask("POST /api/sessions/{session_id}/localization", { session_id: session }, { body: wanted });

export const cancelLocalization = (session: string): Promise<LocalizationStatus> =>
  ask("DELETE /api/sessions/{session_id}/localization", { session_id: session });

export const courseOf = async (session: string): Promise<Course | null> =>
  (await request<{ course: Course | null }>(`${of(session)}/course`)).course;

export const givenMap = async (session: string): Promise<GivenMap | null> =>
  (await request<{ map: GivenMap | null }>(`${of(session)}/map`)).map;

/** Choose the map of a log along one of its trajectories. */
export const chooseLog = async (
  session: string,
  wanted: { readonly log: string; readonly topic: string | null; readonly trajectory: string | null },
): Promise<GivenMap> => (await request<{ map: GivenMap }>(`${of(session)}/map`, "PUT", wanted)).map;

/** Choose map files: a yaml with its image, or a map of CMU's course. */
export async function chooseFiles(session: string, files: readonly File[]): Promise<GivenMap> {
  const named = files.find(({ name }) => /\.ya?ml$/i.test(name)) ?? files[0];
  const title = named?.name ?? "map";
  const body = files.length === 1 && !/\.ya?ml$/i.test(title) ? files[0] : tarred(files, title);
  return (await sent<{ map: GivenMap }>(`${of(session)}/map-files?name=${encodeURIComponent(title)}`, body)).map;
}

async function sent<T>(address: string, body: BodyInit | undefined): Promise<T> {
  let answer: Response;
  try {
    answer = await fetch(address, { method: "PUT", ...(body ? { body } : {}) });
  } catch {
    throw new Error(AWAY);
  }
  if (!answer.ok) throw new Error(await sentence(answer));
  return (await answer.json()) as T;
}
