import { Button } from "../../../ui/Button";
import { Failure } from "../../../ui/Failure";
import { ProgressBar } from "../../../ui/ProgressBar";
import { progressText } from "../../../ui/Working";
import type { SensorState } from "./useSensor";

/** The progress of reading another sensor, with a button that cancels it, or the error. */
export function SensorProgress({ sensor }: { readonly sensor: SensorState }) {
  const { reading, progress, failure, cancel } = sensor;
  const now = progress.value;
  const fraction = now?.fraction ?? null;
  return (
    <div class="sensor-progress">
      <div role="status">
        {reading.value !== null && (
          <>
            <p class="quiet">
              {now?.what ?? `Reading ${reading.value}`} …{" "}
              {now && (
                <span class="number" aria-hidden="true">
                  {progressText(now)}
                </span>
              )}
            </p>
            <ProgressBar fraction={fraction} />
            <Button onClick={cancel}>Cancel</Button>
          </>
        )}
      </div>
      <Failure why={failure.value} />
    </div>
  );
}
