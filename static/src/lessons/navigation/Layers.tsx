import { useLayoutEffect, useRef } from "preact/hooks";
import { NO_INFORMATION, nameOfCost } from "../../grid/costs";
import { CostCurve } from "../../render/chart/CostCurve";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { isDark } from "../../ui/browser/theme";
import { Slider } from "../../ui/Slider";
import { useInSight } from "../common/useSteps";
import type { Costs } from "./costmap";
import { coloursOf } from "./paint";
import {
  INFLATION,
  inflation,
  LAYERS,
  lifetime,
  probeAt,
  ROBOT_RADIUS,
  robotRadius,
  type Sheet as SheetOf,
  sheets,
  switched,
} from "./state";
import { cellOf, GEOMETRY } from "./world";
import "./navigation.css";

const RANGES = {
  inflation_radius: { low: 0, high: 2, step: 0.05 },
  cost_scaling_factor: { low: 0.1, high: 20, step: 0.1 },
} as const;
/** The circumscribed radius of a square footprint over its inscribed one. */
const CORNER = Math.SQRT2;

/** The slider of the robot's inscribed radius, by what the figure uses it for. */
export function RobotRadius({ sentence }: { readonly sentence: string }) {
  return (
    <Slider
      label="Inscribed radius"
      sentence={sentence}
      {...bound(robotRadius)}
      initial={ROBOT_RADIUS}
      low={0.05}
      high={0.8}
      step={0.05}
      unit="m"
    />
  );
}

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
        <RobotRadius sentence="Radius of the largest circle within the footprint, here a square one." />
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

const LIFETIME = 4;
const currentSheets = (): readonly SheetOf[] => sheets.value;

/** The layers of a costmap as sheets, the last one on top; each can be switched off. */
export function Layers() {
  const root = useRef<HTMLDivElement>(null);
  const shown = useInSight(root, currentSheets);
  const cell = cellOf(probeAt.value);
  return (
    <div class="costmap-layers stack-narrow" ref={root}>
      <div class="table-room">
        <table class="plain-table">
          <thead>
            <tr>
              <th scope="col">layer</th>
              <th scope="col" class="layer-cost">
                its cost
              </th>
              <th scope="col" class="layer-cost">
                so far
              </th>
            </tr>
          </thead>
          <tbody>
            {shown.map(({ id, own, master }) => {
              const layer = LAYERS.find((layer) => layer.id === id);
              const isOn = switched.value[id];
              return (
                <tr key={id} class={isOn ? "" : "off"}>
                  <th scope="row">
                    <label class="layer-switch">
                      <span class="toggle">
                        <input
                          type="checkbox"
                          role="switch"
                          aria-checked={isOn}
                          checked={isOn}
                          onChange={(event) => {
                            switched.value = { ...switched.peek(), [id]: event.currentTarget.checked };
                          }}
                        />
                        <span class="toggle-track" />
                      </span>
                      <Sheet costs={own} />
                      <span>
                        <b>{layer?.name}</b>
                        <span class="layer-text">{layer?.text}</span>
                      </span>
                    </label>
                  </th>
                  <td class="layer-cost">{written(own[cell])}</td>
                  <td class="layer-cost">{isOn ? written(master[cell]) : "off"}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
      <div class="figure-controls no-print">
        <Slider
          label="Lifetime in the dynamic layer"
          sentence="Obstacles that were not seen for longer are removed; a person walked past in the last 9 seconds."
          {...bound(lifetime)}
          initial={LIFETIME}
          low={0}
          high={10}
          step={1}
          unit="s"
        />
      </div>
      <p>The costs are those under the cross on the stage.</p>
    </div>
  );
}

const written = (cost = NO_INFORMATION): string => (cost === NO_INFORMATION ? nameOfCost(cost) : String(cost));

/** A layer alone, as a sheet that lies in space. */
function Sheet({ costs }: { costs: Costs }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { rows, cols } = GEOMETRY;
  const dark = isDark.value;
  useLayoutEffect(() => {
    const colours = coloursOf(costs, false);
    const flipped = new Uint8ClampedArray(colours.length);
    for (let row = 0; row < rows; row++)
      flipped.set(colours.subarray(4 * row * cols, 4 * (row + 1) * cols), 4 * (rows - 1 - row) * cols);
    canvas.current?.getContext("2d")?.putImageData(new ImageData(flipped, cols, rows), 0, 0);
  }, [costs, rows, cols, dark]);
  return <canvas class="layer-sheet" ref={canvas} width={cols} height={rows} />;
}
