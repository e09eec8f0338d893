/** The server's examination of a log. */

import { DOCTOR_LEAST_SCANS } from "../../wire/constants";
import type { LogEvent } from "../../wire/messages";
import type { LogInfo, Value } from "../../wire/protocol";
import { followMaking, type Making, newName } from "../making";
import { SENSOR_SEPARATOR } from "./library/describeLog";

export interface Finding {
  readonly check: string;
  /** The topic of the sensor that it is about, in a log of several; else empty. */
  readonly sensor: string;
  readonly sentence: string;
  readonly advice: string;
  /** 0 … 1 */
  readonly sure: number;
  /** Too uncertain to be stated as a fact. */
  readonly possible: boolean;
  /** Scan numbers, from 0. */
  readonly scans: readonly number[];
  /** Their times, s from the log's first scan. */
  readonly seconds: readonly number[];
  /** Values of mapping parameters that would help. */
  readonly parameters: Readonly<Record<string, Value>> | null;
}

export interface Examination {
  readonly trajectory: string;
  /** Causes first. */
  readonly findings: readonly Finding[];
  /** In the order of their times. */
  readonly events: readonly LogEvent[];
}

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
 * Throws an error with the server's message if it is refused.
 */
export async function examine(
  session: string,
  show: (making: Making | null) => void,
  signal: AbortSignal,
): Promise<Examination> {
  const name = newName();
  const stop = followMaking(name, show);
  const answer = await fetch(`/api/sessions/${encodeURIComponent(session)}/doctor?name=${name}`, { signal }).finally(
    stop,
  );
  const body: unknown = await answer.json();
  if (!answer.ok) throw new Error((body as { message?: string }).message ?? "The log could not be examined.");
  return body as Examination;
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
export function confidenceLabel({ sure, possible }: Pick<Finding, "sure" | "possible">): string {
  if (possible) return "possible";
  if (sure >= 0.95) return "certain";
  return sure >= 0.8 ? "very likely" : "likely";
}
