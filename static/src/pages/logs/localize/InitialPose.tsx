import { useId } from "preact/hooks";
import { Choice } from "../../../ui/Choice";
import { NumberField } from "../../../ui/NumberField";
import type { Localizing } from "./localizing";

const FIELDS = [
  [0, "x", "m", 1],
  [1, "y", "m", 1],
  [2, "heading", "°", 180 / Math.PI],
] as const;

/** Of the fields, m or °. */
const STEP = 0.01;

/** Where the robot starts: anywhere, or at a pose that is clicked on the map or written. */
export function InitialPose({ localizing }: { readonly localizing: Localizing }) {
  const pose = localizing.pose.value;
  const id = useId();
  return (
    <>
      <Choice
        label="The robot starts"
        options={[
          { value: "anywhere", label: "Anywhere" },
          { value: "pose", label: "At a pose" },
        ]}
        value={localizing.hasPose.value ? "pose" : "anywhere"}
        onChange={(value) => {
          localizing.hasPose.value = value === "pose";
          localizing.turns.value = false;
        }}
      />
      {localizing.hasPose.value && (
        <>
          <p role="status">
            {localizing.turns.value
              ? "Click on the map in the direction that the robot faces."
              : pose
                ? "Click on the map to place it again."
                : "Click on the map where it starts."}
          </p>
          <div class="localize-pose">
            {FIELDS.map(([i, name, unit, factor]) => (
              <div key={name} class="field">
                <label class="field-label" for={id + name}>
                  {name}, {unit}
                </label>
                <NumberField
                  id={id + name}
                  class="field-text number"
                  step={STEP}
                  value={pose ? pose[i] * factor : Number.NaN}
                  onChange={(value) => {
                    const next: [number, number, number] = [...(pose ?? ([0, 0, 0] as const))];
                    next[i] = value / factor;
                    localizing.pose.value = next;
                  }}
                />
              </div>
            ))}
          </div>
        </>
      )}
    </>
  );
}
