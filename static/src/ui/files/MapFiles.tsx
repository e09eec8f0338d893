import { Button } from "../Button";
import { MapSnapshots } from "./mapSnapshots";

/** One for the page: the names differ from pair to pair in all sessions that it shows. */
const snapshots = new MapSnapshots();

/** Buttons that download a session's map: pgm and yaml, which are of one instant, and png. */
export function MapFiles({ session }: { readonly session: string }) {
  const address = (kind: string): string => `/api/sessions/${encodeURIComponent(session)}/map.${kind}`;
  return (
    <>
      {["pgm", "yaml"].map((kind) => (
        <Button
          key={kind}
          icon="download"
          href={address(kind)}
          download
          onClick={(event) => {
            event.preventDefault();
            save(`${address(kind)}?at=${snapshots.next(session, kind, new Date())}`);
          }}
        >
          {kind}
        </Button>
      ))}
      <Button icon="download" href={address("png")} download>
        png
      </Button>
    </>
  );
}

/** Download a file under the name that the server gives it. */
function save(address: string): void {
  const link = document.createElement("a");
  link.href = address;
  link.download = "";
  link.click();
}
