/** The camera of a 3D view, which this tab keeps for each session: a reload begins where it was. */

/** What is kept of viser's message about its camera, in the map frame, m. */
interface Camera {
  readonly position: readonly number[];
  readonly look_at: readonly number[];
}

const isVector = (value: unknown): value is readonly number[] =>
  Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);

/** The session of a 3D view at an address, `/scenes/ID/…`. */
const keyOf = (path: string): string => `gridbloom.camera.${path.split("/")[2]}`;

/** The query with which viser's client begins where the camera of this session was; null if that is not known. */
export function keptQuery(storage: Storage, { pathname, search }: Location): string | null {
  const { position, look_at } = read(storage.getItem(keyOf(pathname)));
  if (!isVector(position) || !isVector(look_at)) return null;
  const query = new URLSearchParams(search);
  query.set("initialCameraPosition", position.join(","));
  query.set("initialCameraLookAt", look_at.join(","));
  return `?${query}`;
}

function read(text: string | null): Partial<Camera> {
  try {
    return (JSON.parse(text ?? "{}") as Partial<Camera> | null) ?? {};
  } catch {
    return {};
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
