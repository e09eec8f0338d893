/** The scenes and figures of what is built on the map: their code is fetched when the page has been rendered. */

import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { awaited } from "../../ui/browser/awaited";
import { type Scene, scene } from "./scene";

const LATER_IDS = [
  "particles",
  "sensor-models",
  "kidnapping",
  "layers",
  "inflation",
  "path",
  "lifetime",
  "stack",
  "octree",
  "tsdf",
] as const;

export type LaterId = (typeof LATER_IDS)[number];

/** Whether the code of a section's scene and figure is one of these. */
export const isLater = (id: string): id is LaterId => LATER_IDS.some((known) => known === id);

/** What a section of these has: the scene of the stage, and its figure or what stands beside its picture. */
export interface Later {
  readonly scene: () => Scene;
  readonly figure: ComponentType;
  /** A figure in the text after it. */
  readonly more?: ComponentType;
}

export const later = signal<Readonly<Record<LaterId, Later>> | null>(null);

const RETRY_MS = 3000;

/** Fetch the code, again and again while the server does not answer. */
export async function fetchLater(load: () => Promise<NonNullable<typeof later.value>>): Promise<void> {
  try {
    later.value = await awaited(load());
  } catch {
    setTimeout(() => void fetchLater(load), RETRY_MS);
  }
}

/** The scene of a section; the whole map until its code is there. */
export const laterScene = (id: LaterId): Scene =>
  later.value?.[id].scene() ?? scene({ scans: 77, caption: "The map of the whole drive." });
