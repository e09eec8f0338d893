/** The camera of a 3D view, which this tab keeps for each session: a reload begins where it was. */

import type { ShownCamera as Camera } from "../wire/http";

const isVector = (value: unknown): value is Camera["position"] =>
  Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);

/** The session of a 3D view at an address, `/scenes/ID/…`. */
const keyOf = (path: string): string => `gridbloom.camera.${path.split("/")[2]}`;

/** The query with which viser's client begins where the camera of this session was; null if that is not known. */
export function keptQuery(storage: Storage, { pathname, search }: Location): string | null {
  const camera = keptCamera(storage, pathname);
  if (!camera) return null;
  const { position, look_at } = camera;
  const query = new URLSearchParams(search);
  query.set("initialCameraPosition", position.join(","));
  query.set("initialCameraLookAt", look_at.join(","));
  return `?${query}`;
}

/** The camera of the session of a 3D view at an address; null if that is not known. */
export function keptCamera(storage: Storage, path: string): Camera | null {
  try {
    const { position, look_at } = (JSON.parse(storage.getItem(keyOf(path)) ?? "{}") ?? {}) as Partial<Camera>;
    return isVector(position) && isVector(look_at) ? { position, look_at } : null;
  } catch {
    return null;
  }
}

/** Keep the camera that a message of viser's client to its server is about; other messages have none. */
export function keepCamera(storage: Storage, path: string, message: unknown): void {
  const { type, position, look_at } = (message ?? {}) as Partial<Camera> & { readonly type?: string };
  if (type !== "ViewerCameraMessage" || !isVector(position) || !isVector(look_at)) return;
  storage.setItem(keyOf(path), JSON.stringify({ position, look_at }));
}

/** The messages of viser's server that say where a camera is at first. */
const FIRST = ["SetCameraPositionMessage", "SetCameraLookAtMessage", "SetCameraUpDirectionMessage"];

interface CameraMessage {
  readonly type?: string;
  readonly initial?: boolean;
}

/**
 * Gives viser's client the messages about its first camera together. It moves the camera there when the first of them
 * has come: what comes in a later batch changes nothing, and the camera stays at a place that nobody chose.
 */
export class FirstCamera {
  readonly #held = new Map<string, CameraMessage>();

  /** Take them out of a batch until all of them are known. */
  take(messages: CameraMessage[]): void {
    if (this.#held.size === FIRST.length) return;
    for (const message of [...messages]) {
      const { type = "", initial } = message;
      if (!initial || !FIRST.includes(type)) continue;
      messages.splice(messages.indexOf(message), 1);
      this.#held.set(type, message);
    }
    if (this.#held.size === FIRST.length) messages.push(...this.#held.values());
  }
}
