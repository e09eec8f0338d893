import type { Folder } from "../../../ui/files/droppedFiles";

const BLOCK = 512;

/**
 * Several files as one upload: a tar archive (POSIX.1-2017, pax: the ustar format) which has `name`, without copying the
 * files. The same files give the same bytes.
 */
export function tarred(files: readonly File[], name: string): File {
  const parts = files.flatMap((file) => [header(file), file, new Uint8Array(-file.size & (BLOCK - 1))]);
  return new File([...parts, new Uint8Array(2 * BLOCK)], name);
}

function header(file: File): Uint8Array<ArrayBuffer> {
  const block = new Uint8Array(BLOCK);
  const put = (at: number, text: string): void => block.set(new TextEncoder().encode(text), at);
  block.set(new TextEncoder().encode(file.name).slice(-100)); // the end of the name contains the number of the part
  put(100, "0000644\0");
  put(124, file.size.toString(8).padStart(11, "0"));
  put(148, " ".repeat(8));
  put(156, "0");
  put(257, "ustar\0");
  put(263, "00");
  const sum = block.reduce((all, byte) => all + byte, 0);
  put(148, `${sum.toString(8).padStart(6, "0")}\0`);
  return block;
}

/**
 * Files next to logs that are not logs themselves: metadata of ROS 2 bags, SQLite journals, notes, files of file
 * managers.
 */
const NOT_LOGS = /^(metadata\.yaml|\..*|.*\.db3-(wal|shm)|readme.*|.*\.md|Thumbs\.db|desktop\.ini)$/i;

/** A file of a recording, which may have parts; rosbag names an unclosed one .bag.active. */
const RECORDING = /\.(db3|mcap|bag)(\.zstd|\.active)?$/i;

/** The start time of a part, which ROS 1's rosbag writes into its name. */
const BEGUN = /\d{4}(-\d{2}){5}$/;

/**
 * Group files that were selected together into logs: the parts of a split recording, the two files of a sonar ring, or
 * a map.
 */
export function groupIntoLogs({ name, files }: Folder): readonly File[] {
  if (files.length === 1) return files; // the server determines the format
  const parts = splitRecording(files) ?? ring(files) ?? depthImages(files);
  const map = parts ? null : mapFiles(files);
  const rest = files
    .filter((file) => !(parts ?? map)?.includes(file) && !NOT_LOGS.test(file.name))
    .map((file) => withJournal(file, files))
    .map((log) => (log.length === 1 ? log[0] : tarred(log, log[0].name)));
  if (map) return [tarred(map, map[0]?.name ?? "map"), ...rest];
  if (!parts) return rest;
  const whole = parts.flatMap((part) => withJournal(part, files));
  return [tarred(whole, name || nameOf(parts)), ...rest];
}

/** A file with the write-ahead log that SQLite left when a recorder was killed: it contains the last messages. */
function withJournal(file: File, files: readonly File[]): readonly [File, ...File[]] {
  const journal = files.find((other) => other.name === `${file.name}-wal` && other.size > 0);
  return journal ? [file, journal] : [file];
}

function splitRecording(files: readonly File[]): readonly File[] | null {
  const described = files.find((file) => file.name === "metadata.yaml");
  const parts = files.filter((file) => RECORDING.test(file.name));
  const endings = new Set(parts.map((file) => RECORDING.exec(file.name)?.[0].replace(/\.active$/i, "")));
  if (parts.length < 2 || endings.size > 1) return null;
  if (described) return [described, ...parts];
  return arePartsByName(parts) ? parts : null;
}

/** Whether files have the same name but for numbers from 0, as ROS names the parts of a recording. */
function arePartsByName(parts: readonly File[]): boolean {
  const names = parts.map(({ name }) => /^(.+)_(\d+)$/.exec(name.replace(RECORDING, "")));
  const numbers = new Set(names.map((match) => Number(match?.[2] ?? -1)));
  const stems = new Set(names.map((match) => match?.[1]?.replace(BEGUN, "")));
  return stems.size === 1 && names[0] !== null && numbers.size === parts.length && Math.min(...numbers) === 0;
}

function ring(files: readonly File[]): readonly File[] | null {
  const pair = files.filter((file) => file.name === "measurement.txt" || file.name === "poses.txt");
  return pair.length === 2 ? pair : null;
}

/** Depth images with their poses and the camera's parameters, as in 7-Scenes. */
function depthImages(files: readonly File[]): readonly File[] | null {
  if (!files.some(({ name }) => name.endsWith(".depth.png"))) return null;
  return files.filter(({ name }) => /\.(depth\.png|pose\.txt)$|^(camera-)?intrinsics\.txt$|^camera\.txt$/.test(name));
}

/** The yaml of a map, its image, and the files that map editing saves with them; the yaml is first. */
function mapFiles(files: readonly File[]): readonly File[] | null {
  const yamls = files.filter(({ name }) => /\.ya?ml$/i.test(name) && name !== "metadata.yaml");
  const own = yamls.filter(({ name }) => !/_(keepout|speed)\.ya?ml$/i.test(name));
  const images = files.filter(({ name }) => /\.(pgm|png|bmp|jpe?g|tiff?|gif)$/i.test(name));
  const edits = files.filter(({ name }) => name.endsWith(".edits.json"));
  if (own.length !== 1 || images.length === 0) return null;
  return [...own, ...yamls.filter((file) => !own.includes(file)), ...images, ...edits];
}

/** Name of a log whose parts are not in a folder: the name of a part without its number. */
function nameOf(parts: readonly File[]): string {
  const part = parts.find((file) => RECORDING.test(file.name));
  if (part) return part.name.replace(RECORDING, "").replace(/_\d+$/, "");
  return parts.some(({ name }) => name.endsWith(".depth.png")) ? "depth images" : "sonars";
}
