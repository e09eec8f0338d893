import type { Folder } from "../../ui/droppedFiles";
import { tarred } from "./tar";

/** What lies beside logs and is none: ROS 2's description of a bag, SQLite's journals, notes, what file managers leave. */
const BESIDE = /^(metadata\.yaml|\..*|.*\.db3-(wal|shm)|readme.*|.*\.md|Thumbs\.db|desktop\.ini)$/i;

/** A file that ROS 2 records into; its kind is the ending. */
const RECORDING = /\.(db3|mcap)(\.zstd)?$/i;

/** The logs among files that were chosen together: a recording that was split, and a ring of sonars' two, are one. */
export function groupIntoLogs({ name, files }: Folder): readonly File[] {
  if (files.length === 1) return files; // the server says what it is
  const parts = splitRecording(files) ?? ring(files);
  const rest = files.filter((file) => !parts?.includes(file) && !BESIDE.test(file.name));
  return parts ? [tarred(parts, name || nameOf(parts)), ...rest] : rest;
}

function splitRecording(files: readonly File[]): readonly File[] | null {
  const described = files.find((file) => file.name === "metadata.yaml");
  const parts = files.filter((file) => RECORDING.test(file.name));
  const endings = new Set(parts.map((file) => RECORDING.exec(file.name)?.[0]));
  return described && parts.length > 1 && endings.size === 1 ? [described, ...parts] : null;
}

function ring(files: readonly File[]): readonly File[] | null {
  const pair = files.filter((file) => file.name === "measurement.txt" || file.name === "poses.txt");
  return pair.length === 2 ? pair : null;
}

/** What parts that lie in no folder are called: as they are themselves, without their numbers. */
function nameOf(parts: readonly File[]): string {
  const part = parts.find((file) => RECORDING.test(file.name));
  return part ? part.name.replace(RECORDING, "").replace(/_\d+$/, "") : "sonars";
}
