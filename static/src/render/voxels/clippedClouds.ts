/** Point clouds that are clipped in the browser: viser's client is given the points within the box. */

/** A message of viser about a node of the scene; only what concerns clipped clouds. */
export interface NodeMessage {
  readonly type?: string;
  readonly name?: string;
  readonly position?: readonly number[];
  readonly props?: { points?: unknown; colors?: unknown };
  readonly updates?: { readonly points?: Float32Array; readonly colors?: Uint8Array };
  readonly owner?: string;
}

interface Cloud {
  readonly points: Float32Array;
  /** Of each point, or one colour for all. */
  readonly colors: Uint8Array;
}

/** A cloud as it was sent, and of which connection its node is. */
interface SentCloud extends Cloud {
  readonly owner: string;
}

interface Clip {
  low?: readonly number[];
  high?: readonly number[];
}

const CORNER = /^(.*)\/clip_(low|high)$/;

/** The points of a cloud whose coordinates are between the corners, these included, with their colours. */
export function clipped({ points, colors }: Cloud, low: readonly number[], high: readonly number[]): Cloud {
  const [x0 = 0, y0 = 0, z0 = 0] = low;
  const [x1 = 0, y1 = 0, z1 = 0] = high;
  const inBox = new Float32Array(points.length);
  const isOne = colors.length !== points.length;
  const keptColors = new Uint8Array(isOne ? 0 : colors.length);
  let end = 0;
  for (let at = 0; at < points.length; at += 3) {
    const x = points[at] as number;
    const y = points[at + 1] as number;
    const z = points[at + 2] as number;
    if (!(x >= x0 && x <= x1 && y >= y0 && y <= y1 && z >= z0 && z <= z1)) continue;
    for (let k = 0; k < 3; k++) {
      inBox[end + k] = points[at + k] as number;
      if (!isOne) keptColors[end + k] = colors[at + k] as number;
    }
    end += 3;
  }
  return { points: inBox.slice(0, end), colors: isOne ? colors : keptColors.slice(0, end) };
}

/** Remembers the clouds of a scene and their clip boxes. */
export class ClippedClouds {
  readonly #clouds = new Map<string, SentCloud>();
  readonly #clips = new Map<string, Clip>();

  /** Clip the clouds in messages of viser, and add messages about known clouds whose box has changed. */
  take(messages: NodeMessage[]): void {
    const changed = new Set<string>();
    for (const { type, name, owner = "", position, props } of messages) {
      if (name === undefined) continue;
      const corner = type === "SetPositionMessage" && position ? CORNER.exec(name) : null;
      if (corner) {
        const [, path = "", end] = corner;
        const clip = this.#clips.get(path) ?? {};
        clip[end as "low" | "high"] = position as readonly number[];
        this.#clips.set(path, clip);
        changed.add(`${path}/points`);
      } else if (type === "PointCloudMessage" && props?.points instanceof Float32Array) {
        this.#clouds.set(name, { points: props.points, colors: props.colors as Uint8Array, owner });
        Object.assign(props, this.#clip(name));
        changed.delete(name);
      } else if (type === "RemoveSceneNodeMessage") {
        this.#clouds.delete(name);
        this.#clips.delete(name);
      }
    }
    for (const name of changed) {
      const updates = this.#clip(name);
      const owner = this.#clouds.get(name)?.owner;
      if (updates && owner !== undefined) messages.push({ type: "SceneNodeUpdateMessage", name, owner, updates });
    }
  }

  #clip(name: string): Cloud | null {
    const cloud = this.#clouds.get(name);
    const { low, high } = this.#clips.get(name.slice(0, name.lastIndexOf("/"))) ?? {};
    return cloud && low && high ? clipped(cloud, low, high) : null;
  }
}
