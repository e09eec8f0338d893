import type { Store } from "../../../store/store";
import { lookOf } from "../../../tools/volume/state";
import { bytes } from "../../../ui/numbers";

const many = (n: number): string => n.toLocaleString("en");

/** How large the map is, below its picture. */
export function VolumeFacts({ store }: { readonly store: Store }) {
  const now = store.part("volume").message.value;
  if (!now) return <p class="quiet">…</p>;
  const surface = store.part("surface").message.value;
  const isSurface = surface !== null && lookOf(store).values.value.show === "surface";
  const size = now.high.map((high, axis) => high - (now.low[axis] ?? 0));
  return (
    <p class="volume-facts number" data-chunks={now.chunks} data-pending={now.pending} data-occupied={now.occupied}>
      <span>{size.map((side) => side.toFixed(side < 10 ? 1 : 0)).join(" × ")} m</span>
      <span>
        {many(now.points)} {now.has_scans ? "points" : "nodes"}
      </span>
      {isSurface ? (
        <span data-triangles={surface.triangles} data-pending={surface.pending}>
          {many(surface.triangles)} triangles of {surface.index} {surface.index === 1 ? "scan" : "scans"}
        </span>
      ) : (
        <span>
          {many(now.occupied)} voxels occupied{now.free > 0 ? `, ${many(now.free)} free` : ""}
        </span>
      )}
      {isSurface && surface.problem && <span role="status">{surface.problem}</span>}
      {!isSurface && now.pending > 0 && <span role="status">drawing {many(now.pending)} chunks …</span>}
      {now.left_out > 0 && <span>{many(now.left_out)} points left out: beyond the map</span>}
      <span class="visually-hidden">{bytes(now.bytes)} of memory</span>
    </p>
  );
}
