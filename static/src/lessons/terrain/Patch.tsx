import { useSignal } from "@preact/signals";
import { bound, selected, switched } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { SwitchChip } from "../../ui/dock/SwitchChip";
import { Slider } from "../../ui/Slider";
import { PatchFigure } from "./PatchFigure";
import "./terrain.css";
import type { Place } from "./model";

/** Where the points are, m: nearly a lattice. */
const PLACES: readonly (readonly [x: number, y: number])[] = [
  [-0.82, -0.74],
  [0.05, -0.8],
  [0.78, -0.7],
  [-0.72, 0.06],
  [0.02, -0.04],
  [0.84, 0.05],
  [-0.78, 0.76],
  [-0.02, 0.82],
  [0.8, 0.72],
];
const NOISE = [0.01, -0.012, 0.006, -0.008, 0.012, -0.005, 0.004, 0.01, -0.014];

const patch = (height: (x: number, y: number) => number): readonly Place[] =>
  PLACES.map(([x, y], k) => [x, y, height(x, y) + (NOISE[k] as number)]);

interface Preset {
  readonly id: string;
  readonly label: string;
  readonly points: readonly Place[];
}

export const PRESETS: readonly Preset[] = [
  { id: "floor", label: "Floor", points: patch(() => 0.1) },
  { id: "ramp", label: "Ramp", points: patch((x) => 0.3 + 0.28 * x) },
  { id: "stone", label: "Stone", points: patch((x, y) => (Math.hypot(x, y) < 0.2 ? 0.55 : 0.1)) },
  { id: "step", label: "Step", points: patch((x) => (x > 0.4 ? 0.4 : 0.1)) },
];

const DEGREE = Math.PI / 180;
const SLOPE = { low: 5, high: 45, step: 1, initial: 20 };
const ROUGHNESS = { low: 0.02, high: 0.4, step: 0.01, initial: 0.15 };
/** Distance from a plane up to which RANSAC counts a point as one of it, m. */
const NEAR = 0.05;
const HEIGHTS: readonly [number, number] = [-0.3, 0.9];

/** A made-up patch to grab, with RANSAC, every point twice, and limits of what is safe. */
export function Patch() {
  const preset = useSignal("ramp");
  const isRobust = useSignal(false);
  const isTwice = useSignal(false);
  const slope = useSignal(SLOPE.initial);
  const roughness = useSignal(ROUGHNESS.initial);
  return (
    <figure class="patch stack" aria-label="A patch of terrain, its moments, its plane and its class">
      <Choice
        label="Begin with"
        options={PRESETS.map(({ id, label }) => ({ value: id, label }))}
        {...selected(preset)}
      />
      <PatchFigure
        key={preset.value}
        initial={PRESETS.find(({ id }) => id === preset.value)?.points ?? []}
        half={1}
        heights={HEIGHTS}
        floor={0}
        robust={isRobust.value ? NEAR : null}
        isTwice={isTwice.value}
        limits={{ slope: slope.value * DEGREE, roughness: roughness.value }}
      />
      <div class="figure-controls">
        <SwitchChip
          label="Leave out outliers (RANSAC)"
          title="The plane of the three points that most others are within 5 cm of, fitted to those."
          {...switched(isRobust)}
        />
        <SwitchChip
          label="Every point twice"
          title="The residual doubles, though the ground is the same; the roughness does not."
          {...switched(isTwice)}
        />
      </div>
      <div class="figure-controls patch-limits">
        <Slider
          label="Maximum safe slope"
          sentence="The slope at which a smooth patch is just safe."
          unit="°"
          {...bound(slope)}
          {...SLOPE}
        />
        <Slider
          label="Maximum safe roughness"
          sentence="The roughness at which a level patch is just safe."
          unit="m"
          {...bound(roughness)}
          {...ROUGHNESS}
        />
      </div>
    </figure>
  );
}
