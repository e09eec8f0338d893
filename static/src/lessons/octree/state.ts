/** What a reader can change in the section on octrees. */

import { computed } from "@preact/signals";
import { onPath } from "../stage/path";
import { cut, grown } from "./model";

export const resolution = onPath(0.1);
export const height = onPath(0.45);
const whole = computed(() => grown(resolution.value));
export const tree = computed(() => cut(whole.value, height.value));
