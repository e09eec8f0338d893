import { beamModel, halfWindow, type SensorModelParameters } from "../../grid/sensorModel";
import { keyed, type Range, snap } from "../../ui/numbers";
import {
  type Bounds,
  dragEdge,
  dragLevel,
  dragOpening,
  dragRangeMax,
  keyEdge,
  keyLevel,
  type Setting,
} from "./handles";
import type { HandleName, ProfileView } from "./view";

/** Event handlers of a handle of the figure. */
interface HandleEvents {
  readonly onStart: () => void;
  readonly onDrag: (dx: number, dy: number, fine: boolean) => void;
  readonly onEnd: () => void;
  readonly onKey: (key: string, shift: boolean) => boolean;
}

export interface Controls {
  readonly bounds: Bounds;
  reading(on: "beam" | "curve"): HandleEvents;
  rangeMax(on: "beam" | "curve"): HandleEvents;
  edge(side: "near" | "far"): HandleEvents;
  level(which: "hit" | "miss"): HandleEvents;
  /** The edge of the cone, dragged from a point `ahead` of and `aside` the sensor, pixels. */
  opening(ahead: number, aside: number): HandleEvents;
}

/** Ratio of the handle's movement to the pointer's: a fifth while Shift is held. */
const gain = (fine: boolean): number => (fine ? 0.2 : 1);

/** Connect the handles to the view and to the parameters, which `set` changes. */
export function controlsFor(
  view: ProfileView,
  bounds: Bounds,
  set: (name: keyof SensorModelParameters, value: number) => void,
): Controls {
  const apply = (setting: Setting | null): boolean => {
    if (!setting) return false;
    if (view.values.peek()[setting.name] !== setting.value) set(setting.name, setting.value);
    return true;
  };
  let atStart = 0;
  let perPixel = 0;

  const handle = (
    name: HandleName,
    begin: () => void,
    onDrag: (dx: number, dy: number, fine: boolean) => void,
    onKey: (key: string, shift: boolean) => boolean,
  ): HandleEvents => ({
    onStart: () => {
      begin();
      view.held.value = name;
    },
    onDrag,
    onEnd: () => {
      view.held.value = null;
    },
    onKey,
  });

  const metresPerPixel = (on: "beam" | "curve"): number => {
    const scale = on === "beam" ? view.beamScale.peek() : view.xScale.peek();
    return (scale.high - scale.low) / (scale.to - scale.from);
  };
  // A reading can be dragged slightly beyond the max range, to show a beam without a return.
  const readingRange = (): Range => ({ low: 0.01, high: 1.12 * view.values.peek().range_max, step: 0.01 });
  const readingNow = (): number => Math.min(view.z.peek(), readingRange().high);

  return {
    bounds,
    reading: (on) =>
      handle(
        on === "beam" ? "z-far" : "z",
        () => {
          atStart = readingNow();
          perPixel = metresPerPixel(on);
          view.grabbed.value = atStart;
        },
        (dx, _dy, fine) => {
          view.grabbed.value = snap(atStart + dx * perPixel * gain(fine), readingRange());
        },
        (key, shift) => {
          const { resolution } = view.values.peek();
          const next = keyed(key, shift, readingNow(), { ...readingRange(), step: Math.max(0.01, resolution) }, 0.01);
          if (next !== null) view.grabbed.value = next;
          return next !== null;
        },
      ),
    rangeMax: (on) =>
      handle(
        "range_max",
        () => {
          atStart = view.values.peek().range_max;
          perPixel = metresPerPixel(on);
        },
        (dx, _dy, fine) => apply(dragRangeMax(atStart + dx * perPixel * gain(fine), bounds, fine)),
        (key, shift) => {
          const range = bounds("range_max");
          const next = keyed(key, shift, view.values.peek().range_max, { ...range, step: 5 * range.step }, range.step);
          return next !== null && apply({ name: "range_max", value: next });
        },
      ),
    edge: (side) =>
      handle(
        side,
        () => {
          const half = halfWindow(view.z.peek(), view.values.peek());
          atStart = view.z.peek() + (side === "near" ? -half : half);
          perPixel = metresPerPixel("curve");
        },
        (dx, _dy, fine) =>
          apply(dragEdge(side, atStart + dx * perPixel * gain(fine), view.z.peek(), bounds, fine, view.values.peek())),
        (key, shift) => apply(keyEdge(side, key, shift, view.values.peek(), bounds)),
      ),
    opening: (ahead, aside) => {
      let from = { ahead, aside };
      return handle(
        "opening",
        () => {
          from = { ahead, aside };
        },
        (dx, dy, fine) => apply(dragOpening(from.ahead + dx * gain(fine), from.aside - dy * gain(fine), bounds, fine)),
        (key, shift) => {
          const range = bounds("opening");
          const next = keyed(key, shift, view.values.peek().opening, range, range.step / 5);
          return next !== null && apply({ name: "opening", value: next });
        },
      );
    },
    level: (which) =>
      handle(
        which,
        () => {
          atStart = beamModel(view.values.peek())[which];
          const scale = view.yScale.peek();
          perPixel = (scale.high - scale.low) / (scale.to - scale.from);
        },
        (_dx, dy, fine) =>
          apply(dragLevel(which, atStart + dy * perPixel * gain(fine), view.values.peek(), bounds, fine)),
        (key, shift) => apply(keyLevel(which, key, shift, view.values.peek(), bounds)),
      ),
  };
}
