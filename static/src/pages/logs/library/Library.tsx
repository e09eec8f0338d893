import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { toastFailure } from "../../../ui/browser/attempts";
import { Dropzone } from "../../../ui/files/Dropzone";
import { Icon } from "../../../ui/Icon";
import { bytes, clock } from "../../../ui/numbers";
import { ProgressBar } from "../../../ui/ProgressBar";
import { Select } from "../../../ui/Select";
import { groupIntoLogs } from "./groupFiles";
import { LogCard } from "./LogCard";
import {
  allTags,
  arrived,
  EVERYTHING,
  type ExampleName,
  isMoving,
  type LogRecord,
  listError,
  logs,
  ORDERS,
  openExample,
  PAGE,
  total,
  type Wanted,
  wanted,
  watch,
} from "./library";
import { cancel, dismiss, type Upload, uploadAll, uploads } from "./uploading";

/** A rate is shown after it was measured for this time. */
const MEASURED_MS = 2000;

/** The bytes sent of the total, the share, the rate and the remaining time, as far as known at `now`. */
export function uploadText({ bytes: all, sent, since }: Upload, now: number): string {
  if (since === null) return `waiting, ${bytes(all)}`;
  if (sent >= all) return `${bytes(all)} sent; the server stores them …`;
  const share = `${bytes(sent)} of ${bytes(all)}, ${Math.floor((100 * sent) / all)} %`;
  const elapsed = now - since.at;
  const rate = (1000 * (sent - since.sent)) / elapsed;
  if (elapsed < MEASURED_MS || rate <= 0) return share;
  return `${share}, ${bytes(rate)}/s, ${clock((all - sent) / rate)} left`;
}

/** From this number of logs on there are search and sorting. */
const MANY = 7;
/** Delay between a key press and the search. */
const SETTLE_MS = 200;

const isFiltered = (): boolean => wanted.value.words !== "" || wanted.value.tags.length > 0;

const choose = (change: Partial<Wanted>): void => {
  wanted.value = { ...wanted.peek(), limit: PAGE, ...change };
};

/** Search, order and tags; nothing for few logs. */
function Finder() {
  const timer = useRef<ReturnType<typeof setTimeout>>(undefined);
  const tags = Object.entries(allTags.value);
  const now = wanted.value;
  const isAsIs = now === EVERYTHING || (!isFiltered() && now.order === "newest");
  if (logs.value === null || (total.value < MANY && tags.length === 0 && isAsIs)) return null;
  return (
    <search class="finder">
      <input
        class="field-text finder-words"
        type="search"
        placeholder="Search name, format, topic, tag"
        aria-label="Search logs"
        defaultValue={now.words}
        onInput={(event) => {
          const words = event.currentTarget.value.trim();
          clearTimeout(timer.current);
          timer.current = setTimeout(() => choose({ words }), SETTLE_MS);
        }}
      />
      <Select
        class="finder-order"
        label="Order"
        value={now.order}
        options={ORDERS}
        onChange={(order) => choose({ order })}
      />
      {tags.map(([tag, count]) => {
        const isOn = now.tags.includes(tag);
        return (
          <button
            key={tag}
            type="button"
            class="tag"
            aria-pressed={isOn}
            onClick={() => choose({ tags: isOn ? now.tags.filter((kept) => kept !== tag) : [...now.tags, tag] })}
          >
            {tag} <span class="number">{count}</span>
          </button>
        );
      })}
      <span class="visually-hidden" role="status">
        {isFiltered() ? `${total.value} logs found` : ""}
      </span>
    </search>
  );
}

interface Example {
  readonly name: ExampleName;
  readonly title: string;
  /** A suggestion for using it. */
  readonly hint: string;
}

const EXAMPLES: readonly Example[] = [
  {
    name: "drift",
    title: "Poses that drift",
    hint: "Walls appear twice because the wheels slip a little. Press Heal: SLAM corrects the poses; then compare both maps.",
  },
  {
    name: "mount",
    title: "A wrong mount",
    hint: "The lidar is turned in its mount, by how much is not stated. The findings name it, with a button that corrects it.",
  },
  {
    name: "camera",
    title: "Camera and 3D lidar",
    hint: "Choose the layout Map and camera. The button Open in 3D on its card makes voxels: clip them to a box, click one.",
  },
];

/** Simulated logs for a visitor who has none. */
function Examples() {
  const making = useSignal<ExampleName | null>(null);
  const begin = async (name: ExampleName): Promise<void> => {
    making.value = name;
    await toastFailure(() => openExample(name));
    making.value = null;
  };
  return (
    <section class="shelf">
      <h2>No log at hand?</h2>
      <ul class="cards">
        {EXAMPLES.map(({ name, title, hint }) => (
          <li key={name} class="card example-card">
            <h3>{title}</h3>
            <p>{hint}</p>
            <Button disabled={making.value !== null} onClick={() => void begin(name)}>
              {making.value === name ? "Simulating …" : `Open: ${title.charAt(0).toLowerCase()}${title.slice(1)}`}
            </Button>
          </li>
        ))}
      </ul>
    </section>
  );
}

/** The kinds of files that can be dropped, by how they are opened. */
const FORMATS: readonly (readonly [opened: string, formats: string])[] = [
  ["A log", "ROS 1 bag, ROS 2 bag (.db3), MCAP, CARMEN, CMU, DP-SLAM, BreezySLAM, CSV, a ring of sonars"],
  ["In several files", "the folder of a recording, or a tar archive of it (.tar, .tar.gz)"],
  ["A map to edit", "its yaml and image together"],
  [
    "A map in 3D",
    "PCD, PLY, XYZ, VTK, LAS, LAZ; OctoMap (.graph, .bt, .ot); depth images (7-Scenes, TUM), folder or zip",
  ],
];

const Formats = () => (
  <details class="formats">
    <summary>All formats</summary>
    <dl>
      {FORMATS.map(([opened, formats]) => (
        <div key={opened}>
          <dt>{opened}</dt>
          <dd>{formats}</dd>
        </div>
      ))}
    </dl>
  </details>
);

/** The list of all logs, and the drop zone for uploads. */
export function Library({ onOpen }: { onOpen: (log: LogRecord, topic: string | null, in3d?: boolean) => void }) {
  useEffect(watch, []);
  useSignalEffect(() => {
    const log = logs.value?.find((log) => log.id === arrived.value);
    if (!log || isMoving(log)) return;
    arrived.value = null;
    if (log.state === "ready") onOpen(log, null);
  });
  const list = logs.value;
  const own = list?.filter((log) => log.source === "upload") ?? [];
  const sample = list?.filter((log) => log.source === "sample") ?? [];
  const folder = list?.filter((log) => log.source === "folder") ?? [];
  return (
    <div class="library">
      <div class="page-head">
        <h1>Robot logs</h1>
        <p class="prose">
          Open a log and watch its map fill in. When you change a parameter, the whole map is computed again from every
          reading of the log. <a href="/fleet.html">Map all logs</a> to see all their maps at once.
        </p>
      </div>
      <Dropzone button="Choose a log" onFolders={(folders) => uploadAll(folders.flatMap(groupIntoLogs))}>
        <p>
          <strong>Drop a log here: a file, or the folder of a ROS 2 recording</strong>
        </p>
        <p class="quiet">
          ROS bags, MCAP, CARMEN and other logs, plain or compressed; clouds and maps too. Your logs are visible in this
          browser only, unless you share a view.
        </p>
        <Formats />
      </Dropzone>
      {uploads.value.map((upload) => (
        <UploadCard key={upload.key} upload={upload} />
      ))}
      {listError.value && (
        <p class="notice" role="alert">
          <Icon name="warning" /> {listError.value}
        </p>
      )}
      {list === null && !listError.value && (
        <div class="cards" aria-busy="true">
          <div class="card ghost" />
          <div class="card ghost" />
          <div class="card ghost" />
        </div>
      )}
      <Finder />
      {list?.length === 0 && (
        <p class="notice">
          {isFiltered() ? "No log has all of these words and tags." : "There are no logs yet. Drop one above."}
        </p>
      )}
      <Shelf title="Your logs" list={own} onOpen={onOpen} />
      {list !== null && own.length === 0 && !isFiltered() && <Examples />}
      <Shelf title="On this server" list={[...sample, ...folder]} onOpen={onOpen} />
      {list !== null && total.value > list.length && (
        <div class="library-more">
          <Button
            onClick={() => {
              wanted.value = { ...wanted.value, limit: wanted.value.limit + PAGE };
            }}
          >
            Show more
          </Button>
          <span class="quiet number">
            {list.length} of {total.value.toLocaleString("en")} logs
          </span>
        </div>
      )}
    </div>
  );
}

interface ShelfProps {
  readonly title: string;
  readonly list: readonly LogRecord[];
  readonly onOpen: (log: LogRecord, topic: string | null, in3d?: boolean) => void;
}

function Shelf({ title, list, onOpen }: ShelfProps) {
  if (list.length === 0) return null;
  return (
    <section class="shelf">
      <h2>{title}</h2>
      <ul class="cards">
        {list.map((log) => (
          <LogCard key={log.id} log={log} onOpen={onOpen} />
        ))}
      </ul>
    </section>
  );
}

function UploadCard({ upload: one }: { upload: Upload }) {
  const part = one.bytes > 0 ? one.sent / one.bytes : 0;
  return (
    <div class={`upload${one.error ? " failed" : ""}`} role={one.error ? "alert" : "status"}>
      <Icon name={one.error ? "warning" : "upload"} />
      <div class="upload-text">
        <strong>{one.name}</strong>
        {one.error ? (
          <p>{one.error}</p>
        ) : (
          <>
            {/* Hidden from screen readers, which would announce it with every part. */}
            <p class="quiet number" aria-hidden="true">
              {uploadText(one, performance.now())}
            </p>
            <ProgressBar fraction={part} label={`Uploading ${one.name}`} />
          </>
        )}
      </div>
      {one.error ? (
        <Button kind="quiet" icon="close" label="Dismiss" onClick={() => dismiss(one.key)} />
      ) : (
        <Button kind="quiet" icon="close" label={`Cancel the upload of ${one.name}`} onClick={() => cancel(one.key)} />
      )}
    </div>
  );
}
