/** Requests about the localization of a log in a map. Each rejects with the server's sentence. */

import { ask } from "../../../wire/ask";
import type { FilterHistory, LocalizationStatus, MapAnswer, MapOfLog, NewLocalization } from "../../../wire/http";
import { tarred } from "../library/groupFiles";

export type { FilterHistory, LocalizationStatus, MapAnswer };

export const localizationState = (session: string): Promise<LocalizationStatus> =>
  ask("GET /api/sessions/{session_id}/localization", { session_id: session });

export const localize = (session: string, body: NewLocalization): Promise<LocalizationStatus> =>
  ask("POST /api/sessions/{session_id}/localization", { session_id: session }, { body });

export const cancelLocalization = (session: string): Promise<LocalizationStatus> =>
  ask("DELETE /api/sessions/{session_id}/localization", { session_id: session });

/** How certain the poses in use are along the log; null where they come from no localization. */
export const filterHistory = async (session: string): Promise<FilterHistory | null> =>
  (await ask("GET /api/sessions/{session_id}/localization/course", { session_id: session })).course;

/** The map that was chosen; null for none. */
export const referenceMap = async (session: string): Promise<MapAnswer | null> =>
  (await ask("GET /api/sessions/{session_id}/localization/map", { session_id: session })).map;

/** Choose the map of a log along one of its trajectories. */
export const chooseLog = async (session: string, body: MapOfLog): Promise<MapAnswer | null> =>
  (await ask("PUT /api/sessions/{session_id}/localization/map", { session_id: session }, { body })).map;

/** Choose map files: a yaml with its image, or a map of CMU's course. */
export async function chooseFiles(session: string, files: readonly File[]): Promise<MapAnswer | null> {
  const isYaml = ({ name }: File): boolean => /\.ya?ml$/i.test(name);
  const named = files.find(isYaml) ?? files[0];
  if (!named) return null;
  const body = files.length === 1 && !isYaml(named) ? named : tarred(files, named.name);
  const what = "PUT /api/sessions/{session_id}/localization/map-files";
  return (await ask(what, { session_id: session }, { query: { name: named.name }, body })).map;
}
