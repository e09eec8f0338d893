/**
 * Script of the 3D view, inserted by server/scenes/proxy.py before those of viser's client: it makes glTF files of the
 * chunks of voxels before the client reads the messages that they are in.
 *
 * The client's worker passes messages on; a listener that is added when the worker is made hears them first.
 */

import { voxelGlb } from "../render/voxels/voxelGlb";
import { decodeVoxels, isVoxelChunk } from "../wire/decodeVoxels";

/** A message of viser; those with glTF files have them as `props.glb_data`. */
interface SceneMessage {
  readonly props?: { glb_data?: unknown };
}

function expand({ data }: MessageEvent<{ readonly messages?: readonly SceneMessage[] }>): void {
  for (const { props } of data?.messages ?? []) {
    const file = props?.glb_data;
    if (props && file instanceof Uint8Array && isVoxelChunk(file)) props.glb_data = voxelGlb(decodeVoxels(file));
  }
}

window.Worker = class extends window.Worker {
  constructor(...given: ConstructorParameters<typeof Worker>) {
    super(...given);
    this.addEventListener("message", expand);
  }
};
