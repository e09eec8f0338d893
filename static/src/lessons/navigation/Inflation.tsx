import { CostCurve } from "../../render/chart/CostCurve";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { INFLATION, inflation, ROBOT_RADIUS, robotRadius } from "./state";
import "./navigation.css";

const RANGES = {
  inflation_radius: { low: 0, high: 2, step: 0.05 },
  cost_scaling_factor: { low: 0.1, high: 20, step: 0.1 },
} as const;
/** The circumscribed radius of a square footprint over its inscribed one. */
const CORNER = Math.SQRT2;

/** The curve of the cost over the distance, and the robot's radius. */
export function InflationCurve() {
  return (
    <div class="inflation-controls stack-narrow">
      <CostCurve
        inscribed={robotRadius.value}
        circumscribed={robotRadius.value * CORNER}
        inflation={inflation.value}
        ranges={RANGES}
        onChange={(name, value) => {
          inflation.value = { ...inflation.peek(), [name]: value };
        }}
      />
      <div class="figure-controls no-print">
        <Slider
          label="Inscribed radius"
          sentence="Radius of the largest circle within the footprint, here a square one."
          {...bound(robotRadius)}
          initial={ROBOT_RADIUS}
          low={0.05}
          high={0.8}
          step={0.05}
          unit="m"
        />
        <Button
          icon="restart"
          onClick={() => {
            inflation.value = INFLATION;
            robotRadius.value = ROBOT_RADIUS;
          }}
        >
          Reset
        </Button>
      </div>
    </div>
  );
}
