/** What a reader can change in the section on octrees. */

import { computed } from "@preact/signals";
import { onPath } from "../stage/path";
import { octree } from "./model";

export const resolution = onPath(0.1);
export const height = onPath(0.45);
export const tree = computed(() => octree(resolution.value, height.value));
