/** The server's examination of a log. */

import { ask } from "../../wire/ask";
import { DOCTOR_LEAST_SCANS } from "../../wire/constants";
import type { DoctorAnswer, FindingAnswer } from "../../wire/http";
import type { LogInfo } from "../../wire/protocol";
import { followMaking, type Making, newName } from "../making";
import { SENSOR_SEPARATOR } from "./library/describeLog";

/**
 * Whether the server certainly examines a log: it refuses one in which no sensor has enough scans. The numbers of the
 * single sensors are not known here, but the greatest is at least their mean.
 */
export function isLongEnough(log: Pick<LogInfo, "n_scans" | "topic"> | null): boolean {
  return log !== null && log.n_scans >= DOCTOR_LEAST_SCANS * log.topic.split(SENSOR_SEPARATOR).length;
}

/**
 * Examine the log of a session; `show` is called with how far that is, and `signal` ends it.
 *
 * Rejects with the server's sentence if it is refused.
 */
export function examine(
  session: string,
  show: (making: Making | null) => void,
  signal: AbortSignal,
): Promise<DoctorAnswer> {
  const name = newName();
  const stop = followMaking(name, show);
  const options = { query: { name }, ending: signal };
  return ask("GET /api/sessions/{session_id}/doctor", { session_id: session }, options).finally(stop);
}

/**
 * What an examination without findings says: of poses in which the robot does not move only that, as drift, delay and
 * mount are judged by readings from different places.
 */
export function wellLabel(poses: string, stands: boolean): readonly [result: string, about: string] {
  if (!stands) return ["No problems found.", `Poses: ${poses}.`];
  return ["No problems found in the readings.", "The poses do not move, so drift, delay and mount cannot be checked."];
}

/** The certainty of a finding in words. */
export function confidenceLabel({ sure, possible }: Pick<FindingAnswer, "sure" | "possible">): string {
  if (possible) return "possible";
  if (sure >= 0.95) return "certain";
  return sure >= 0.8 ? "very likely" : "likely";
}
