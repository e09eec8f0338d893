import { useMemo } from "preact/hooks";
import { Button } from "./Button";
import { Moments } from "./moments";

/** Buttons that download a session's map: pgm and yaml, which are of one instant, and png. */
export function MapFiles({ session }: { readonly session: string }) {
  const moments = useMemo(() => new Moments(), [session]);
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
            save(`${address(kind)}?at=${moments.next(kind, new Date())}`);
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
