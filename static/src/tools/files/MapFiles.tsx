import { Button } from "../../ui/Button";
import { addressOf } from "../../wire/ask";
import { FileButton } from "./FileButton";

/** Milliseconds after which the second file of a pair gets a new instant. */
const PAIR_MS = 600_000;

/**
 * Names of the instants of maps whose files are downloaded one after the other. Files of a session requested with the
 * same name are of the same map, and their file names end in it. No two pairs have the same name.
 */
export class MapSnapshots {
  private session = "";
  private name = "";
  private begun = 0;
  private readonly taken = new Set<string>();
  private readonly names = new Set<string>();

  /**
   * Return the name for a file of a kind: that of the session's preceding file of the other kind, otherwise the current
   * time, or the first later second that is not the name of an earlier pair.
   */
  next(session: string, kind: string, now: Date): string {
    const isLate = now.getTime() - this.begun > PAIR_MS;
    if (this.name === "" || session !== this.session || this.taken.has(kind) || isLate) {
      this.session = session;
      this.name = this.unused(now);
      this.begun = now.getTime();
      this.taken.clear();
      this.names.add(this.name);
    }
    this.taken.add(kind);
    return this.name;
  }

  private unused(now: Date): string {
    let time = now.getTime();
    while (this.names.has(localTime(new Date(time)))) {
      time += 1000;
    }
    return localTime(new Date(time));
  }
}

/** Local time in characters that any file name allows: 2026-01-31_09-05-59. */
function localTime(time: Date): string {
  const two = (value: number): string => String(value).padStart(2, "0");
  const date = [time.getFullYear(), two(time.getMonth() + 1), two(time.getDate())].join("-");
  return `${date}_${[time.getHours(), time.getMinutes(), time.getSeconds()].map(two).join("-")}`;
}

/** One for the page, so that the names differ from pair to pair in all sessions that it shows. */
const snapshots = new MapSnapshots();

/** Buttons that download a session's map: pgm and yaml, which are of one instant, and png. */
export function MapFiles({ session }: { readonly session: string }) {
  const address = (kind: "pgm" | "yaml", at?: string): string =>
    addressOf(`GET /api/sessions/{session_id}/map.${kind}`, { session_id: session }, at === undefined ? {} : { at });
  return (
    <>
      {(["pgm", "yaml"] as const).map((kind) => (
        <Button
          key={kind}
          icon="download"
          href={address(kind)}
          download
          onClick={(event) => {
            event.preventDefault();
            save(address(kind, snapshots.next(session, kind, new Date())));
          }}
        >
          {kind}
        </Button>
      ))}
      <FileButton session={session} file="map.png">
        png
      </FileButton>
    </>
  );
}

/** Download a file under the name that the server chooses. */
function save(address: string): void {
  const link = document.createElement("a");
  link.href = address;
  link.download = "";
  link.click();
}
