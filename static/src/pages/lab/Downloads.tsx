import type { Store } from "../../store/store";
import { MapFiles } from "../../tools/files/MapFiles";
import { EditMap } from "../../tools/mapediting/EditMap";
import { MakePuzzle } from "../../tools/puzzle/MakePuzzle";
import { Button } from "../../ui/Button";
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
async function share(id: string, store: Store): Promise<void> {
  try {
    const link = await snapshotAddress(id, store);
    await copy(link, "Link copied. It opens a copy of this world, map and settings.");
  } catch {
    toast("The server does not answer, so no link could be made.", "error");
  }
}

/** Links to this world, and its map as files. */
export function Downloads({ id, store }: { readonly id: string; readonly store: Store }) {
  return (
    <div class="lab-share">
      <div class="actions">
        <Button icon="link" onClick={() => void share(id, store)}>
          Share
        </Button>
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
      <p class="quiet">
        Share makes a link to a copy of this world. Live link makes a link to this world itself: others watch it and
        drive the robot.
      </p>
      <MakePuzzle session={id} />
      <div class="actions">
        <MapFiles session={id} />
        <EditMap session={id} name={store.hello.value?.title ?? "world"} />
      </div>
      <p class="quiet">
        pgm and yaml together are a map for map_server and Nav2; both show the map at the moment of the first download.
        png is an image of the map.
      </p>
    </div>
  );
}
