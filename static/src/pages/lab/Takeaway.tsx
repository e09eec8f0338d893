import { Button } from "../../ui/Button";
import { Panel } from "../../ui/Panel";
import { toast } from "../../ui/Toast";
import { shareAddress } from "./session";

/** Copy the session's address. */
export async function share(id: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(shareAddress(id));
    toast("The link is copied. Whoever opens it sees this very world, and can steer the robot too.");
  } catch {
    toast("Copy the address of this page: it opens this very world.");
  }
}

/** The map as files. */
export function Takeaway({ id }: { readonly id: string }) {
  const file = (kind: string): string => `/api/sessions/${encodeURIComponent(id)}/map.${kind}`;
  return (
    <Panel title="Take the map away">
      <div class="lab-downloads">
        {["pgm", "yaml", "png"].map((kind) => (
          <Button key={kind} icon="download" href={file(kind)} download>
            {kind}
          </Button>
        ))}
      </div>
      <p class="panel-note">pgm and yaml together open in map_server and Nav2; png is for people.</p>
    </Panel>
  );
}
