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
