import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { Dropzone } from "../../ui/Dropzone";
import type { Folder } from "../../ui/droppedFiles";
import { bytes } from "../../ui/numbers";
import { groupIntoLogs } from "../logs/groupFiles";
import { arrivalAddress, arrived } from "../logs/library";
import { upload, uploads } from "../logs/uploading";
import { Section, type SectionHead } from "./Section";

/** Uploads files and then opens the logs page; a log that comes alone is opened there once it was read. */
function YourLog() {
  const sending = uploads.value;
  const failed = sending.some((one) => one.error !== null);
  const begun = useRef(false);
  const take = (folders: readonly Folder[]): void => {
    begun.current = true;
    const logs = folders.flatMap(groupIntoLogs);
    for (const log of logs) upload(log, logs.length === 1);
  };
  useEffect(() => {
    if (begun.current && sending.length === 0) location.assign(arrivalAddress(arrived.peek()));
  }, [sending]);
  return (
    <figure class="your-log" aria-label="Open your own log">
      <Dropzone onFolders={take} button="Choose files">
        <p>
          <b>Drop a log here.</b> Its map opens and fills in.
        </p>
      </Dropzone>
      <p role="status">
        {sending.map(({ key, name, bytes: size, sent, error }) => (
          <span key={key} class={failed ? "noun-hit" : ""}>
            {name}: {error ?? `${bytes(sent)} of ${bytes(size)} sent`}{" "}
          </span>
        ))}
      </p>
      <div class="actions">
        <Button kind="primary" icon="file" href="/logs.html">
          All logs
        </Button>
        <Button href="/lab.html">Drive a robot in the lab</Button>
      </div>
    </figure>
  );
}

export function LogSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<YourLog />}
      sources={[
        ["laser-scan", "the fields of a scan"],
        ["rep-105", "the frames of the poses"],
      ]}
    >
      <p>
        The examples above were small. The log of a real robot has thousands of scans and hundreds of thousands of
        readings. On the logs page you can change the same parameters as on this page, and the whole map is computed
        again from every reading while you drag.
      </p>
    </Section>
  );
}
