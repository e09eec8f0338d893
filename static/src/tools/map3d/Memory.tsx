/** The memory of the 3D map in three forms, as bars on a logarithmic scale. */

import { bytes as sizeOf } from "../../ui/numbers";
import type { Map3dMessage, SurfaceMessage } from "../../wire/protocol";

/** Bytes of an empty bar. */
const LEAST = 1000;

/** The share 0 … 1 of a bar on a logarithmic scale that ends at `most`. */
const shareOf = (bytes: number, most: number): number =>
  bytes <= LEAST || most <= LEAST ? 0 : Math.min(1, Math.log(bytes / LEAST) / Math.log(most / LEAST));

interface MemoryProps {
  readonly message: Map3dMessage;
  /** The surface that is shown; null for none. */
  readonly surface: SurfaceMessage | null;
}

export function Memory({ message, surface }: MemoryProps) {
  const { known, nodes, leaves, octree_bytes, block_bytes, dense_bytes, scans, taken } = message;
  const rows = [
    { name: "Octree", bytes: octree_bytes, what: `${nodes.toLocaleString("en")} nodes` },
    { name: "Blocks of 8³", bytes: block_bytes, what: `${known.toLocaleString("en")} known voxels` },
    ...(surface ? [{ name: "Signed distances", bytes: surface.bytes, what: "of blocks near surfaces" }] : []),
    { name: "Dense grid", bytes: dense_bytes, what: "of the whole world" },
  ];
  const most = Math.max(dense_bytes, block_bytes, 1);
  return (
    <section class="map3d-memory" aria-label="Memory of the 3D map">
      <dl>
        {rows.map(({ name, bytes, what }) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>
              <span class="map3d-bar" style={{ inlineSize: `${100 * shareOf(bytes, most)}%` }} aria-hidden="true" />
              <span class="map3d-bytes">
                {sizeOf(bytes)} · {what}
              </span>
            </dd>
          </div>
        ))}
      </dl>
      <p class="map3d-note">
        {scans < taken
          ? `The map is being computed again: ${scans} of ${taken} scans.`
          : `${scans} scans. Eight equal voxels are one node: ${leaves.toLocaleString("en")} leaves hold ${known.toLocaleString("en")} voxels.`}{" "}
        Bars are logarithmic.
      </p>
    </section>
  );
}
