import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { MapFiles } from "../../../ui/files/MapFiles";
import { Panel } from "../../../ui/Panel";

/** The map as an octree and from above. */
export function VolumeDownloads({ store, session }: { readonly store: Store; readonly session: string }) {
  const address = (name: string): string => `/api/sessions/${encodeURIComponent(session)}/${name}`;
  const hasSurface = (store.part("surface").message.value?.table.length ?? 0) > 0;
  return (
    <Panel title="Download">
      <div class="actions downloads">
        <Button icon="download" href={address("volume.bt")} download>
          bt
        </Button>
        <Button icon="download" href={address("volume.ot")} download>
          ot
        </Button>
        <MapFiles session={session} />
        <Button icon="download" href={address("selection.ply")} download>
          points in the clip box
        </Button>
        {hasSurface && (
          <>
            <Button icon="download" href={address("surface.ply")} download>
              ply
            </Button>
            <Button icon="download" href={address("surface.glb")} download>
              glb
            </Button>
          </>
        )}
      </div>
      <p class="quiet">
        bt and ot are octrees for OctoMap: bt has free and occupied voxels, ot their log-odds. pgm and yaml together are
        the map from above for map_server and Nav2.
        {hasSurface && " ply and glb are the surface as triangles with normals, for MeshLab, Blender and others."}
      </p>
    </Panel>
  );
}
