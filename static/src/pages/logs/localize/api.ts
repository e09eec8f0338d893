/** Requests about the localization of a log in a map. Each rejects with the server's sentence. */

import { ask } from "../../../wire/ask";
import type { FilterHistory, LocalizationStatus, MapAnswer } from "../../../wire/http";
import type { Pose, Values } from "../../../wire/protocol";
import { tarred } from "../library/tar";

export type { FilterHistory, LocalizationStatus, MapAnswer };

export const localizationState = (session: string): Promise<LocalizationStatus> =>
  ask("GET /api/sessions/{session_id}/localization", { session_id: session });

export const localize = (
  session: string,
  wanted: { readonly initial_pose: Pose | null; readonly odometry: string | null; readonly parameters: Values },
): Promise<LocalizationStatus> =>
  ask("POST /api/sessions/{session_id}/localization", { session_id: session }, { body: wanted });

export const cancelLocalization = (session: string): Promise<LocalizationStatus> =>
  ask("DELETE /api/sessions/{session_id}/localization", { session_id: session });

/** How certain the poses in use are along the log; null where they come from no localization. */
export const filterHistory = async (session: string): Promise<FilterHistory | null> =>
  (await ask("GET /api/sessions/{session_id}/localization/course", { session_id: session })).course;

/** The map that was chosen; null for none. */
export const referenceMap = async (session: string): Promise<MapAnswer | null> =>
  (await ask("GET /api/sessions/{session_id}/localization/map", { session_id: session })).map;

/** Choose the map of a log along one of its trajectories. */
export const chooseLog = async (
  session: string,
  wanted: { readonly log: string; readonly topic: string | null; readonly trajectory: string | null },
): Promise<MapAnswer | null> =>
  (await ask("PUT /api/sessions/{session_id}/localization/map", { session_id: session }, { body: wanted })).map;

/** Choose map files: a yaml with its image, or a map of CMU's course. */
export async function chooseFiles(session: string, files: readonly File[]): Promise<MapAnswer | null> {
  const named = files.find(({ name }) => /\.ya?ml$/i.test(name)) ?? files[0];
  const title = named?.name ?? "map";
  const file = files.length === 1 && !/\.ya?ml$/i.test(title) ? files[0] : tarred(files, title);
  const what = "PUT /api/sessions/{session_id}/localization/map-files";
  return (await ask(what, { session_id: session }, { query: { name: title }, file })).map;
}
