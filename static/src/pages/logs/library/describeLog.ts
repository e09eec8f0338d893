/** Descriptions of a log for the page. */

import { inUtc } from "../../../store/shownTime";
import { bytes, clock, written } from "../../../ui/numbers";
import { timeText } from "../../../ui/text/timeText";
import { progressText } from "../../../ui/Working";
import type { LogRecord, Topic } from "./library";

/** Labels of the trajectories named by the readers and the simulator. */
const TRAJECTORY_LABELS: Readonly<Record<string, string>> = {
  scan: "scan poses",
  odom: "odometry",
  wheel: "wheel odometry",
  odometry: "wheel odometry",
  truepos: "ground truth",
  true: "ground truth",
};

export const trajectoryLabel = (trajectory: string): string =>
  TRAJECTORY_LABELS[trajectory] ?? trajectory.replace(/^tf\/(.*)$/, "tf, in $1");

/** A phrase of the readers as a sentence. */
export const sentence = (phrase: string): string =>
  `${phrase.charAt(0).toUpperCase()}${phrase.slice(1)}${/[.!?]$/.test(phrase) ? "" : "."}`;

/** Metres as text. */
const metres = (length: number): string => `${length < 10 ? length.toFixed(1) : Math.round(length)} m`;

/** Duration, length and number of scans of the run. Empty until the log is read. */
export function run(log: LogRecord): readonly string[] {
  if (log.scans === null) return [];
  if (log.map) {
    const { cols, rows, resolution } = log.map;
    return [
      `${metres(cols * resolution)} × ${metres(rows * resolution)}`,
      `cells of ${written(100 * resolution, 1)} cm`,
    ];
  }
  const length = log.trajectories[0]?.length_m ?? 0;
  return [
    ...(log.duration_s ? [clock(log.duration_s)] : []),
    ...(length > 0 ? [`${metres(length)} driven`] : []),
    ...(log.clouds > 0 ? cloudRun(log) : [scanRun(log)]),
  ];
}

const scanRun = (log: LogRecord): string =>
  log.costmaps > 0 ? `${log.costmaps.toLocaleString("en")} costmaps` : `${(log.scans ?? 0).toLocaleString("en")} scans`;

function cloudRun({ clouds, points, format }: LogRecord): readonly string[] {
  const isTree = format?.startsWith("OctoMap") ?? false;
  return [
    `${points.toLocaleString("en")} ${isTree ? "leaves" : "points"}`,
    ...(clouds > 1 ? [`${clouds.toLocaleString("en")} scans in 3D`] : []),
  ];
}

/** Number of beams, format and size of the file. */
export function file(log: LogRecord): readonly string[] {
  return [
    ...(log.beams === null || !isScanned(log) ? [] : [log.beams === 1 ? "1 beam" : `${log.beams} beams`]),
    ...(log.format ? [log.format] : []),
    ...(log.source === "sample" ? [] : [bytes(log.bytes)]),
  ];
}

/** A pose on the robot as text: metres ahead and to the left, degrees counter-clockwise. */
function place([x = 0, y = 0, yaw = 0]: readonly number[]): string {
  const turned = (yaw * 180) / Math.PI;
  const parts = [
    ...(Math.abs(x) >= 0.005 ? [`${Math.abs(x).toFixed(2)} m ${x > 0 ? "ahead" : "behind"}`] : []),
    ...(Math.abs(y) >= 0.005 ? [`${Math.abs(y).toFixed(2)} m to the ${y > 0 ? "left" : "right"}`] : []),
    ...(Math.abs(turned) >= 0.5 ? [`turned by ${written(turned, 0)}°`] : []),
  ];
  return parts.length > 0 ? parts.join(", ") : "at the robot’s centre";
}

/** Time of the scans and mount of the sensor, one phrase per line. */
export function inside(log: LogRecord): readonly string[] {
  const { time } = log;
  const sensor = log.topics.find((topic) => topic.chosen);
  // A file that names the sensor's frame but not its position: the centre is a guess.
  const mount = !isScanned(log) || (sensor?.frame && !sensor.mount) ? null : log.mount;
  const unit = log.costmaps > 0 ? "costmaps" : "scans";
  const gaps = (n: number): string => (n === 1 ? "1 gap" : `${n.toLocaleString("en")} gaps`);
  return [
    ...(time?.start_s
      ? [`Recorded ${new Date(time.start_s * 1000).toISOString().slice(0, 16).replace("T", " ")} UTC`]
      : []),
    ...(time?.rate_hz
      ? [
          `${written(time.rate_hz, 1)} ${unit} a second${
            time.gaps > 0
              ? `; ${gaps(time.gaps)}, the longest of ${written(time.longest_gap_s, 1)} s at ${timeText(time.longest_gap_at_s, inUtc.value ? time.start_s : null)}`
              : ", without gaps"
          }`,
        ]
      : []),
    ...(log.mount && !mount && isScanned(log)
      ? ["Sensor mount not stated in the file; the robot’s centre is assumed"]
      : []),
    ...(mount ? [`Sensor ${place(mount)}${log.upside_down ? ", upside-down" : ""}`] : []),
  ];
}

/** Between the names of sensors that are mapped together. */
export const SENSOR_SEPARATOR = " + ";

/** The topic of transforms in which a sensor's frames are looked up, if its name contains it; null otherwise. */
export const transformsOf = (sensor: string): string | null => /#(\/.*)$/.exec(sensor)?.[1] ?? null;

/** The names of a log's lidars whose frames are known, each once, those with most scans first. */
export function lidars(log: LogRecord): readonly string[] {
  return log.topics
    .filter((topic) => topic.beams !== null && /Scan$|laser scan$/.test(topic.type) && topic.count > 0)
    .filter((topic) => transformsOf(topic.name) === null)
    .map((topic) => topic.name);
}

/** Whether it has planar scans: it is not a map, a cloud or a recording of costmaps. */
const isScanned = (log: LogRecord): boolean => log.costmaps === 0 && log.clouds === 0 && !log.map;

/** Whether messages of a type are point clouds, from which a 3D map can be made. */
export const isCloud = (type: string): boolean => /\/(PointCloud2|CustomMsg)$/.test(type);

/** Whether a recording has point clouds. */
export const hasClouds = (log: LogRecord): boolean => log.topics.some(({ type, count }) => isCloud(type) && count > 0);

/** A topic as one line. */
export function topic(recorded: Topic): string {
  const transforms = transformsOf(recorded.name);
  return [
    `${recorded.count.toLocaleString("en")} × ${recorded.type.replace(/^.*\//, "")}`,
    ...(recorded.beams === null ? [] : [recorded.beams === 1 ? "1 beam" : `${recorded.beams} beams`]),
    ...(recorded.field_of_view_deg === null ? [] : [`${Math.round(recorded.field_of_view_deg)}°`]),
    ...(recorded.rate_hz === null ? [] : [`${written(recorded.rate_hz, 1)} Hz`]),
    ...(recorded.frame ? [`frame ${recorded.frame}`] : []),
    ...(transforms === null ? [] : [`frames looked up in ${transforms}`]),
  ].join(", ");
}

const REMEDIES: readonly (readonly [codes: RegExp, remedy: string])[] = [
  [
    /\.(empty|missing)$/,
    "CARMEN and gmapping logs, ROS bags, MCAP, DP-SLAM, BreezySLAM and CSV logs can be read, and PCD, PLY, VTK, LAS, XYZ, OctoMap’s files and zips of depth images.",
  ],
  [/\.(unknown_format|binary|garbage)$/, "Convert other formats first."], // the error names the readable formats
  [
    /\.(truncated|gzip|compression|sqlite|unreadable)$/,
    "Copy the file again from where it was recorded; this copy is damaged.",
  ],
  [/^log\.header$/, "Correct the lines before the scans, and try again."],
  [
    /^(depth\.list|log\.(beam_angles|beam_count|beams_vary|not_a_number|parameter|pose|range_max|stamp|ticks|truncated_line))$/,
    "Correct or remove that line, and try again.", // the error names the line
  ],
  [/\.poses$/, "A ring of sonars is two files: choose measurement.txt and poses.txt together, or drop their folder."],
  [/\.archive$/, "Unpack the archive and drop the folder here."],
  [/\.no_scans$/, "A map needs the range readings. Check whether another file of the same run has them."],
  [/\.(too_\w+|line_too_long|time|memory)$/, "Cut the log into shorter pieces."],
  [/\.(cancelled|interrupted|reader_died|reader_failed|storage|stalled)$/, "Try again; the log itself may be intact."],
];

/** The progress of reading a log. */
export function readingText({ state, progress, reading_s }: LogRecord): string {
  if (state === "reading") return `being read: ${progressText({ fraction: progress, elapsed_s: reading_s ?? 0 })}`;
  return state === "queued" ? "waits to be read" : "not yet read";
}

/** Errors of a log that could perhaps be read but is not. */
const REPORTABLE = /^log\.(unknown_format|binary|garbage|no_scans|version|header|beam\w*|not_a_number|range\w*)$/;

const HOW_TO_REPORT =
  "If it should be read, report it: gridbloom info LOG --report writes what it is made of, without readings or names.";

/** Possible actions for a log that failed. */
export function remedy(log: LogRecord): string {
  const code = log.error?.code ?? "";
  const remedy = REMEDIES.find(([codes]) => codes.test(code))?.[1];
  return [remedy, REPORTABLE.test(code) ? HOW_TO_REPORT : ""].filter(Boolean).join(" ");
}
