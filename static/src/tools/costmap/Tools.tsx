/** The effect of a click on the maps while a group of the costmap is open. */

import { useId } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { inHand } from "../../ui/browser/media";
import { Choice } from "../../ui/Choice";
import { Slider } from "../../ui/Slider";
import { limitUnit } from "./paint";
import { costmapOf, type MapTool, type Over } from "./state";

const TOOLS: readonly { readonly tool: MapTool; readonly label: string; readonly hint: string }[] = [
  { tool: "goal", label: "Set goal", hint: "Click a map to set the goal; drag the goal, and the path follows." },
  { tool: "keepout", label: "Keepout", hint: "Paint on a map where the robot must not go." },
  {
    tool: "speed",
    label: "Speed limit",
    hint: "Paint on a map where the robot must be slower. The path stays the same.",
  },
  { tool: "erase", label: "Eraser", hint: "Paint over a zone to erase it." },
  { tool: "cost", label: "Why", hint: "Click a cell: each layer says why it has its cost." },
];
const OVERS: readonly { readonly value: Over | "none"; readonly label: string }[] = [
  { value: "costmap", label: "Costs" },
  { value: "potential", label: "Wavefront" },
  { value: "none", label: "Nothing" },
];

export function Tools({ store }: { readonly store: Store }) {
  const state = costmapOf(store);
  const name = useId();
  const now = state.tool.value ?? state.lastTool.value;
  const strokes = state.costmap.value?.keepout ?? [];
  const isBrush = now === "keepout" || now === "speed" || now === "erase";
  const take = (tool: MapTool): void => {
    state.lastTool.value = state.tool.value = tool;
    store.editing.take(null);
  };
  return (
    <div class="stack-narrow">
      <div class="choice" role="radiogroup" aria-label="What a click on a map does">
        {TOOLS.map(({ tool, label }) => (
          <label class="choice-option" key={tool}>
            <input type="radio" name={name} checked={tool === now} onChange={() => take(tool)} />
            {label}
          </label>
        ))}
      </div>
      <p class="navigation-note">{inHand(TOOLS.find(({ tool }) => tool === now)?.hint ?? "")}</p>
      {isBrush && (
        <>
          <Slider
            label="Brush"
            sentence="Width of the brush."
            unit="m"
            {...bound(state.brush)}
            initial={0.5}
            low={0.1}
            high={2}
            step={0.1}
          />
          {now === "speed" && <Limit store={store} />}
          <div class="actions">
            <Button
              icon="undo"
              disabled={strokes.length === 0}
              onClick={() => costmapOf(store).setKeepout(strokes.slice(0, -1), strokes)}
            >
              Undo stroke
            </Button>
            <Button
              icon="trash"
              disabled={strokes.length === 0}
              onClick={() => costmapOf(store).setKeepout([], strokes)}
            >
              Clear all
            </Button>
          </div>
        </>
      )}
    </div>
  );
}

/** The limit that the brush paints. */
function Limit({ store }: { readonly store: Store }) {
  const { limit, values } = costmapOf(store);
  const { unit, step } = limitUnit(values.values.value.speed_limits);
  return (
    <Slider
      label="Limit"
      sentence="How fast the robot may be in the zone, at most."
      unit={unit}
      value={limit.value * step}
      initial={40 * step}
      low={5 * step}
      high={100 * step}
      step={5 * step}
      onInput={(value) => {
        limit.value = Math.round(value / step);
      }}
    />
  );
}

/** Which grid is drawn over the belief. */
export function OverChoice({ store }: { readonly store: Store }) {
  const { over } = costmapOf(store);
  return (
    <Choice
      label="Over the belief"
      sentence="Costs: dark is an obstacle, magenta is within the robot’s inscribed radius, yellow to red is near. Wavefront: the cost to come from the robot, in bands."
      options={OVERS}
      value={over.value ?? "none"}
      onChange={(value) => {
        over.value = value === "none" ? null : value;
      }}
    />
  );
}
