import { Button } from "../../../ui/Button";
import { MapFiles } from "../../../ui/MapFiles";
import { Panel } from "../../../ui/Panel";

/** The map as an octree and from above. */
export function VolumeDownloads({ session }: { readonly session: string }) {
  const address = (name: string): string => `/api/sessions/${encodeURIComponent(session)}/${name}`;
  return (
    <Panel title="Download">
      <div class="downloads">
        <Button icon="download" href={address("volume.bt")} download>
          bt
        </Button>
        <Button icon="download" href={address("volume.ot")} download>
          ot
        </Button>
        <MapFiles session={session} />
      </div>
      <p class="quiet">
        bt and ot are octrees for OctoMap: bt has free and occupied voxels, ot their log-odds. pgm and yaml together are
        the map from above for map_server and Nav2.
      </p>
    </Panel>
  );
}
