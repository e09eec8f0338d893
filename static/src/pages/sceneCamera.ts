/** The camera of a 3D view: whether a person has moved it, and its pose, which this tab stores for each session. */

import type { ShownCamera as Camera } from "../wire/http";

const isVector = (value: unknown): value is Camera["position"] =>
  Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);

/** The session of a 3D view at an address, `/scenes/ID/…`. */
const keyOf = (path: string): string => `gridbloom.camera.${path.split("/")[2]}`;

/** The query that starts viser's client at the stored camera of this session; null if there is none. */
export function keptQuery(storage: Storage, { pathname, search }: Location): string | null {
  const camera = keptCamera(storage, pathname);
  if (!camera) return null;
  const { position, look_at } = camera;
  const query = new URLSearchParams(search);
  query.set("initialCameraPosition", position.join(","));
  query.set("initialCameraLookAt", look_at.join(","));
  return `?${query}`;
}

/** The camera to which a person moved the view of the session at an address; null if nobody has. */
export function keptCamera(storage: Storage, path: string): Camera | null {
  try {
    const { position, look_at } = (JSON.parse(storage.getItem(keyOf(path)) ?? "{}") ?? {}) as Partial<Camera>;
    return isVector(position) && isVector(look_at) ? { position, look_at } : null;
  } catch {
    return null;
  }
}

interface CameraMessage {
  readonly type?: string;
  readonly initial?: boolean;
}

/**
 * Distinguishes a camera moved by a person from one placed by the server. The server aims only the latter again, for
 * another aspect ratio or other bounds, and the tab stores only the former.
 */
export class MovedCamera {
  readonly #storage: Storage | null;
  readonly #path: string;
  #isMoved: boolean;
  /** Whether the server knows, in the present connection, that the camera was moved. */
  #isReported = false;
  /** Whether a person has dragged, turned the wheel or pressed a key since the server last placed the camera. */
  #hasActed = false;
  #last = "";

  /** `isMoved`: the view starts with a stored camera. `storage` is null if the browser forbids it. */
  constructor(storage: Storage | null, path: string, isMoved: boolean) {
    this.#storage = storage;
    this.#path = path;
    this.#isMoved = isMoved;
  }

  /** Whether a person has moved it. */
  get isMoved(): boolean {
    return this.#isMoved;
  }

  /** A person acts in a way that may move the camera. */
  acted(): void {
    this.#hasActed = true;
  }

  /** The client has a connection, which may be another one. */
  connected(): void {
    this.#isReported = false;
  }

  /** Messages of viser's server, which may place the camera. */
  take(messages: readonly CameraMessage[]): void {
    if (!messages.some(({ type, initial }) => type === "SetCameraPositionMessage" && !initial)) return;
    this.#isMoved = this.#isReported = this.#hasActed = false;
    this.#storage?.removeItem(keyOf(this.#path));
  }

  /** Whether to report, before a message of viser's client to its server, that a person has moved the camera. */
  reports(message: unknown): boolean {
    const { type, position, look_at } = (message ?? {}) as Partial<Camera> & CameraMessage;
    if (type !== "ViewerCameraMessage" || !isVector(position) || !isVector(look_at)) return false;
    const now = JSON.stringify({ position, look_at });
    this.#isMoved ||= this.#hasActed && now !== this.#last;
    this.#last = now;
    if (!this.#isMoved) return false;
    this.#storage?.setItem(keyOf(this.#path), now);
    const isNews = !this.#isReported;
    this.#isReported = true;
    return isNews;
  }
}

/** The messages of viser's server with the initial camera. */
const FIRST = ["SetCameraPositionMessage", "SetCameraLookAtMessage", "SetCameraUpDirectionMessage"];

/**
 * Passes the messages with the initial camera to viser's client together. The client moves the camera when the first of
 * them arrives; those in a later batch have no effect, and the camera would stay at an arbitrary place.
 */
export class FirstCamera {
  readonly #held = new Map<string, CameraMessage>();

  /** Whether the client has received all of them. */
  get isKnown(): boolean {
    return this.#held.size === FIRST.length;
  }

  /** Remove them from a batch until all of them are known. */
  take(messages: CameraMessage[]): void {
    if (this.isKnown) return;
    for (const message of [...messages]) {
      const { type = "", initial } = message;
      if (!initial || !FIRST.includes(type)) continue;
      messages.splice(messages.indexOf(message), 1);
      this.#held.set(type, message);
    }
    if (this.isKnown) messages.push(...this.#held.values());
  }
}
