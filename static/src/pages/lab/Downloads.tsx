import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { MapFiles } from "../../ui/MapFiles";
import { Panel } from "../../ui/Panel";
import { toast } from "../../ui/Toast";
import { liveAddress, snapshotAddress } from "./session";

async function copy(text: string, done: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    toast(done);
  } catch {
    toast("The browser does not allow copying. Copy the address of the page instead.");
  }
}

/** Copy a link to a snapshot of the world and the view. */
export async function share(id: string, store: Store): Promise<void> {
  try {
    const link = await snapshotAddress(id, store);
    await copy(link, "Link copied. It opens a copy of this world, map and settings.");
  } catch {
    toast("The server does not answer, so no link could be made.", "error");
  }
}

/** Downloads of the map, and a link to the live session. */
export function Downloads({ id }: { readonly id: string }) {
  return (
    <Panel title="Download">
      <div class="lab-downloads">
        <MapFiles session={id} />
        <Button
          icon="link"
          onClick={() =>
            void copy(
              liveAddress(id),
              "Link copied. Everyone who opens it sees this world live and can drive the robot.",
            )
          }
        >
          Live link
        </Button>
      </div>
      <p class="panel-note">
        pgm and yaml together are a map for map_server and Nav2; both show the map at the moment of the first download.
        png is an image of the map. Share makes a link to a copy of this world. Live link makes a link to this world
        itself: others watch it and drive the robot.
      </p>
    </Panel>
  );
}
