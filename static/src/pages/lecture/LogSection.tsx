import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { Dropzone } from "../../ui/Dropzone";
import type { Folder } from "../../ui/droppedFiles";
import { bytes } from "../../ui/numbers";
import { groupIntoLogs } from "../logs/groupFiles";
import { upload, uploads } from "../logs/library";
import { Section } from "./Section";

/** Sends files to the server and, when all are up, goes to the page that lists them. */
function YourLog() {
  const sending = uploads.value;
  const failed = sending.some((one) => one.error !== null);
  const begun = useRef(false);
  const take = (folders: readonly Folder[]): void => {
    begun.current = true;
    for (const log of folders.flatMap(groupIntoLogs)) upload(log);
  };
  useEffect(() => {
    if (begun.current && sending.length === 0) location.assign("/logs.html");
  }, [sending]);
  return (
    <figure class="your-log" aria-label="A log of your own">
      <Dropzone onFolders={take} button="Choose files">
        <p>
          <b>Drop a log here.</b> Its map fills in on the logs page.
        </p>
      </Dropzone>
      <p class="quiet" role="status">
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
        <Button href="/lab.html">The lab, with a robot to drive</Button>
      </div>
    </figure>
  );
}

export function LogSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<YourLog />}
      sources={[
        ["laser-scan", "what a log keeps of a scan"],
        ["rep-105", "the frames that its poses lie between"],
      ]}
    >
      <p>
        Everything above was small. Now take a real robot’s log: thousands of scans, hundreds of thousands of readings.
        The parameters are the same ones that you dragged on this page, and the map is made anew, from every reading,
        while you drag them there.
      </p>
    </Section>
  );
}
