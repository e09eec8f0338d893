import type { Store } from "../../../store/store";

/**
 * How many of a recording's clouds there are up to the time of another map of it, as if they came at even intervals:
 * when each came is not known here. All of them where one of the two has no times; null until both have told.
 */
export function cloudsAt(clouds: Store, main: Store): number | null {
  const [own, other] = [clouds.hello.value?.log, main.hello.value?.log];
  const frame = main.frame.value;
  const count = clouds.hello.value?.log?.n_scans ?? 0;
  if (!own || !other || !frame || count === 0) return null;
  if (own.start_s === null || other.start_s === null || own.duration_s <= 0 || frame.index === frame.count)
    return count;
  const since = other.start_s + frame.stamp - own.start_s;
  return since < 0 ? 0 : Math.min(count, 1 + Math.floor((since / own.duration_s) * (count - 1)));
}
