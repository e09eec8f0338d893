import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Button } from "../../ui/Button";
import { ask } from "../../wire/ask";
import { run } from "../logs/library/describeLog";
import { LogPicture } from "../logs/library/LogPicture";
import type { LogRecord } from "../logs/library/library";

const SAMPLE = "sample-office";
/** Time between two questions whether the sample was made. */
const AGAIN_MS = 1000;

/** What stands here while there are no logs: what the page does, and the sample as an example of its cards. */
export function FleetStart() {
  return (
    <section class="fleet-start" aria-label="Without logs">
      <div class="fleet-start-text">
        <p>
          <strong>There are no logs with scans here yet.</strong> Once there are, one press maps all of them, and each
          gets a card with
        </p>
        <ul>
          <li>its map, its number of scans and the size of the map,</li>
          <li>the drift in metres and the sharpness of the map, by which the cards can be ordered,</li>
          <li>what the doctor found in it, or why it could not be read.</li>
        </ul>
        <div class="actions">
          <Button kind="primary" icon="upload" href="/logs.html">
            Add logs
          </Button>
        </div>
        <p class="quiet">
          A folder of this machine: <code>gridbloom serve --logs-dir FOLDER</code>. Without pages:{" "}
          <code>gridbloom fleet LOGS --out FOLDER</code>.
        </p>
      </div>
      <Example />
    </section>
  );
}

function Example() {
  const sample = useSignal<LogRecord | null>(null);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isGone = false;
    const look = async (): Promise<void> => {
      // without an answer the page says so above
      sample.value = await ask("GET /api/logs/{log_id}", { log_id: SAMPLE }).catch(() => null);
      if (!isGone && !sample.value?.has_picture) timer = setTimeout(() => void look(), AGAIN_MS);
    };
    void look();
    return () => {
      isGone = true;
      clearTimeout(timer);
    };
  }, []);
  const log = sample.value;
  return (
    <div class="fleet-example">
      <p class="quiet">An example</p>
      <div class="card fleet-card">
        <LogPicture
          id={SAMPLE}
          hasPicture={log?.has_picture ?? false}
          isAwaited={!log?.has_picture}
          alt="Map of the sample"
        />
        <h2>
          <a href={`/logs.html?log=${SAMPLE}`}>{log?.name ?? "Sample"}</a>
        </h2>
        <p class="quiet number">{log ? run(log).join(", ") : ""}</p>
      </div>
    </div>
  );
}
