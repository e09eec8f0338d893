/**
 * Whether the picture of a 3D view is at rest. viser's client draws a frame every second in case that it has missed a
 * change: at rest it would draw the same picture again, which takes a browser without a graphics card much of its time.
 */

/** RENDER_HEARTBEAT_MS in `App.tsx` of viser's client: the period of these frames. */
export const HEARTBEAT_MS = 1000;
/** The effects of a change, such as textures that are decoded, may appear for this long, ms. */
const EFFECTS_MS = 10_000;

/** All times are in ms, on one clock. */
export class SceneRest {
  #changedAt = Number.NEGATIVE_INFINITY;

  /** A message has arrived, or a person has done something on the view. */
  changed(now: number): void {
    this.#changedAt = now;
  }

  isAtRest(now: number): boolean {
    return now - this.#changedAt > EFFECTS_MS;
  }
}

/** Return a `setInterval` whose tasks of the period of the client's frames are left out while `isAtRest`. */
export function intervalUntilRest(
  set: (task: () => void, period?: number) => number,
  isAtRest: () => boolean,
): (task: () => void, period?: number) => number {
  return (task, period) => set(period === HEARTBEAT_MS ? () => isAtRest() || task() : task, period);
}
