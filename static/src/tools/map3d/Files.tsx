/** The 3D map as files: octrees, the outside of its voxels as triangles, and the map from above. */

import { Button } from "../../ui/Button";

const FILES = ["volume.bt", "volume.ot", "surface.ply", "surface.glb", "above.pgm", "above.yaml"];

interface FilesProps {
  readonly session: string;
  /** Whether the surface is shown instead of the voxels. */
  readonly isSurface: boolean;
}

export function Files({ session, isSurface }: FilesProps) {
  return (
    <>
      <div class="actions">
        {FILES.map((name) => (
          <Button key={name} icon="download" href={`/api/sessions/${encodeURIComponent(session)}/${name}`} download>
            {name.split(".")[1]}
          </Button>
        ))}
      </div>
      <p class="map3d-note">
        bt and ot are octrees for OctoMap, ply and glb {isSurface ? "the surface" : "the outside of the voxels"} as
        triangles, pgm and yaml the map from above, of the band of heights, for map_server.
      </p>
    </>
  );
}
