import type { Store } from "../../store/store";

/**
 * The range shown in the profile: that of the beam towards the inspected point; without one, of the beam with a return
 * that is nearest to straight ahead. Metres, null for no return, undefined before the first scan.
 */
export function profileReading(store: Store): number | null | undefined {
  const beam = store.inspectedBeam.value;
  if (!beam) return undefined;
  const ranges = store.frame.value?.ranges ?? [];
  if (store.probe.value) return beam.range;
  const limit = Number(store.mapping.values.value.range_max ?? Number.POSITIVE_INFINITY);
  for (let away = 0; away < ranges.length; away++) {
    for (const index of [beam.index - away, beam.index + away]) {
      const range = ranges[index];
      if (typeof range === "number" && range <= limit) return range;
    }
  }
  return beam.range;
}
