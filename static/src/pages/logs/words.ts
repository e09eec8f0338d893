/** What is known of a log, in the words of people. */

import { bytes, clock } from "../../ui/numbers";
import type { LogRecord } from "./library";

/** Whose word it is where the robot was: the readers' names of trajectories, and the simulator's. */
const WITNESSES: Readonly<Record<string, string>> = {
  scan: "scan poses",
  odom: "odometry",
  wheel: "wheel odometry",
  odometry: "wheel odometry",
  truepos: "the truth",
  true: "the truth",
};

export const witness = (trajectory: string): string => WITNESSES[trajectory] ?? trajectory;

/** A phrase of the readers as a sentence. */
export const sentence = (phrase: string): string =>
  `${phrase.charAt(0).toUpperCase()}${phrase.slice(1)}${/[.!?]$/.test(phrase) ? "" : "."}`;

/** Metres, as one says them. */
const metres = (length: number): string => `${length < 10 ? length.toFixed(1) : Math.round(length)} m`;

/** The run: how long, how far, how many scans. Empty while nothing is known. */
export function run(log: LogRecord): readonly string[] {
  if (log.scans === null) return [];
  const length = log.trajectories[0]?.length_m ?? 0;
  return [
    ...(log.duration_s ? [clock(log.duration_s)] : []),
    ...(length > 0 ? [`${metres(length)} driven`] : []),
    `${log.scans.toLocaleString("en")} scans`,
  ];
}

/** The scanner and the file. */
export function file(log: LogRecord): readonly string[] {
  return [
    ...(log.beams === null ? [] : [`${log.beams} beams`]),
    ...(log.format ? [log.format] : []),
    ...(log.source === "sample" ? [] : [bytes(log.bytes)]),
  ];
}

const REMEDIES: readonly (readonly [codes: RegExp, remedy: string])[] = [
  [
    /\.(unknown_format|binary|garbage|empty|missing)$/,
    "CARMEN logs, ROS bags, MCAP and DP-SLAM logs can be read. Others have to be converted first.",
  ],
  [
    /\.(truncated|gzip|compression|sqlite|unreadable)$/,
    "Copy the file again from where it was recorded; this copy is damaged.",
  ],
  [/\.no_scans$/, "A map needs the range readings. Is there another file of the same run?"],
  [/\.(too_\w+|line_too_long|time|memory)$/, "Cut the log into shorter pieces."],
  [/\.(interrupted|reader_died|reader_failed|storage|stalled)$/, "Try it again; the log itself may be sound."],
];

/** What one can do about a log that failed. */
export function remedy(log: LogRecord): string {
  const found = REMEDIES.find(([codes]) => codes.test(log.error?.code ?? ""));
  if (found) return found[1];
  return log.error?.message.startsWith("Line ") ? "Mend or remove that line, and try again." : "";
}
