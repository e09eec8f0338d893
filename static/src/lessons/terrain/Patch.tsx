import { useSignal } from "@preact/signals";
import { Choice } from "../../ui/Choice";
import { Slider } from "../../ui/Slider";
import { SwitchChip } from "../../ui/SwitchChip";
import { consensus, momentsOf, type Place, planeOf } from "./model";
import { Matrix, Result } from "./PatchNumbers";
import { PatchView } from "./PatchView";
import { PRESETS } from "./patches";
import "./terrain.css";

const DEGREE = Math.PI / 180;
const SLOPE = { low: 5, high: 45, step: 1, initial: 20 };
const ROUGHNESS = { low: 0.02, high: 0.4, step: 0.01, initial: 0.15 };
/** Distance from a plane up to which RANSAC counts a point as one of it, m. */
const NEAR = 0.05;
const RAMP = PRESETS[1]?.points ?? [];

/** A patch that one grabs: its points are dragged up and down, and P, the plane and the class follow. */
export function Patch() {
  const preset = useSignal("ramp");
  const points = useSignal<readonly Place[]>(RAMP);
  /** The points before the one that was moved last was moved. */
  const before = useSignal<readonly Place[]>(RAMP);
  const moved = useSignal(-1);
  const isRobust = useSignal(false);
  const isTwice = useSignal(false);
  const slope = useSignal(SLOPE.initial);
  const roughness = useSignal(ROUGHNESS.initial);

  const used = isRobust.value ? consensus(points.value, NEAR) : points.value.map(() => true);
  const taken = (all: readonly Place[]): readonly Place[] => {
    const some = all.filter((_, k) => used[k]);
    return isTwice.value ? [...some, ...some] : some;
  };
  const moments = momentsOf(taken(points.value));
  const plane = planeOf(moments);
  return (
    <figure class="patch" aria-label="A patch of terrain, its moments, its plane and its class">
      <Choice
        label="Begin with"
        options={PRESETS.map(({ id, label }) => ({ value: id, label }))}
        value={preset.value}
        onChange={(id) => {
          preset.value = id;
          points.value = before.value = PRESETS.find((one) => one.id === id)?.points ?? RAMP;
          moved.value = -1;
        }}
      />
      <PatchView
        points={points.value}
        plane={plane}
        used={used}
        onMove={(index, z) => {
          if (moved.peek() !== index) before.value = points.peek();
          moved.value = index;
          points.value = points.peek().map(([x, y, old], k) => [x, y, k === index ? z : old]);
        }}
      />
      <div class="patch-numbers">
        <Matrix moments={moments} before={momentsOf(taken(before.value))} />
        <Result plane={plane} limits={{ slope: slope.value * DEGREE, roughness: roughness.value }} />
      </div>
      <div class="figure-controls">
        <SwitchChip
          label="Leave out outliers (RANSAC)"
          title="The plane of the three points that most others are within 5 cm of, fitted to those."
          checked={isRobust.value}
          onChange={(on) => {
            isRobust.value = on;
          }}
        />
        <SwitchChip
          label="Every point twice"
          title="The residual doubles, though the ground is the same; the roughness does not."
          checked={isTwice.value}
          onChange={(on) => {
            isTwice.value = on;
          }}
        />
      </div>
      <div class="figure-controls patch-limits">
        <Slider
          label="Greatest safe slope"
          sentence="A slope that makes a smooth patch just safe."
          unit="°"
          value={slope.value}
          {...SLOPE}
          onInput={(value) => {
            slope.value = value;
          }}
        />
        <Slider
          label="Greatest safe roughness"
          sentence="A roughness that makes a level patch just safe."
          unit="m"
          value={roughness.value}
          {...ROUGHNESS}
          onInput={(value) => {
            roughness.value = value;
          }}
        />
      </div>
    </figure>
  );
}
