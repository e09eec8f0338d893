import { Choice } from "../../../ui/Choice";
import type { Pose } from "../../../wire/protocol";
import type { Localizing } from "./localizing";

const FIELDS = [
  ["x", "m", 1],
  ["y", "m", 1],
  ["heading", "°", 180 / Math.PI],
] as const;

/** Where the robot starts: anywhere, or at a pose that is clicked on the map or written. */
export function InitialPose({ localizing }: { readonly localizing: Localizing }) {
  const pose = localizing.pose.value;
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
            {FIELDS.map(([name, unit, factor], i) => (
              <label key={name} class="field">
                <span class="field-label">
                  {name}, {unit}
                </span>
                <input
                  class="field-text number"
                  type="number"
                  step="any"
                  value={pose ? Number(((pose[i] ?? 0) * factor).toFixed(2)) : ""}
                  onChange={(event) => {
                    const value = event.currentTarget.valueAsNumber;
                    if (!Number.isFinite(value)) return;
                    const next: [number, number, number] = [...(pose ?? [0, 0, 0])] as [number, number, number];
                    next[i] = value / factor;
                    localizing.pose.value = next as Pose;
                  }}
                />
              </label>
            ))}
          </div>
        </>
      )}
    </>
  );
}
