import type { Store } from "../../state";
import { Button } from "../../ui/Button";
import { MapFiles } from "../../ui/MapFiles";
import { Panel } from "../../ui/Panel";
import { toast } from "../../ui/Toast";
import { liveAddress, momentAddress } from "./session";

async function copy(text: string, done: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    toast(done);
  } catch {
    toast("This browser does not let the page copy: copy the address above, it says the same.");
  }
}

/** Copy a link to this moment. */
export async function share(id: string, store: Store): Promise<void> {
  try {
    const link = await momentAddress(id, store);
    await copy(link, "The link is copied. It opens exactly this, world, map and settings, as a world of its own.");
  } catch {
    toast("The server does not answer, so there is no link yet.", "error");
  }
}

/** The map as files, and the world as a link to it while it lives. */
export function Takeaway({ id }: { readonly id: string }) {
  return (
    <Panel title="Take it away">
      <div class="lab-downloads">
        <MapFiles session={id} />
        <Button
          icon="link"
          onClick={() =>
            void copy(
              liveAddress(id),
              "The link is copied. Whoever opens it sees this very world, live, and can steer the robot too.",
            )
          }
        >
          Live link
        </Button>
      </div>
      <p class="panel-note">
        pgm and yaml together open in map_server and Nav2: both are of the moment when you download the first of them.
        png is for people. Share copies this moment; the live link lets others watch and steer this very world.
      </p>
    </Panel>
  );
}
