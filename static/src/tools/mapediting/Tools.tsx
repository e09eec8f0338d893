/** The tools that draw in a map, their drawings, and operations on the whole map. */

import { useSignal } from "@preact/signals";
import { useEffect, useId } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { bound, selected } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { Icon } from "../../ui/Icon";
import type { IconName } from "../../ui/iconPaths";
import { Slider } from "../../ui/Slider";
import { type MapTool, mapEditingOf } from "./state";
import { WIDEST_M } from "./strokes";
import "./mapediting.css";

interface ToolText {
  readonly tool: MapTool | null;
  readonly label: string;
  readonly icon: IconName;
  readonly hint: string;
}

const TOOLS: readonly ToolText[] = [
  { tool: "brush", label: "Brush", icon: "pen", hint: "Paint on the map. Free erases noise, occupied draws walls." },
  { tool: "line", label: "Line", icon: "wall", hint: "Drag from one end of a wall to the other." },
  { tool: "area", label: "Area", icon: "box", hint: "Drag over an area to fill it." },
  { tool: "keepout", label: "Keepout", icon: "blank", hint: "Drag over a zone that robots must not enter." },
  { tool: "speed", label: "Speed", icon: "gauge", hint: "Drag over a zone in which robots drive slower." },
  {
    tool: "straighten",
    label: "Straighten",
    icon: "curve",
    hint: "Drag along a wall: the map turns so that it lies level or upright.",
  },
  { tool: "crop", label: "Crop", icon: "fit", hint: "Drag over the part to keep." },
  {
    tool: "origin",
    label: "Origin",
    icon: "target",
    hint: "Drag from the place of the new origin towards its x axis.",
  },
  { tool: null, label: "Move", icon: "map", hint: "Drag to move the picture; click a cell to read it." },
];

const DRAWN = ["brush", "line", "area"] as const;

export function Tools({ store }: { readonly store: Store }) {
  const mapEditing = mapEditingOf(store);
  const name = useId();
  const now = mapEditing.tool.value;
  const isDrawn = DRAWN.some((tool) => tool === now);
  const isArea = now === "area" || now === "keepout" || now === "speed";
  return (
    <div class="stack-narrow">
      <div class="mapediting-tools" role="radiogroup" aria-label="Tool">
        {TOOLS.map(({ tool, label, icon }) => (
          <label class="mapediting-tool" key={label}>
            <input type="radio" name={name} checked={tool === now} onChange={() => mapEditing.choose(tool)} />
            <Icon name={icon} />
            {label}
          </label>
        ))}
      </div>
      <p class="mapediting-note">{TOOLS.find(({ tool }) => tool === now)?.hint}</p>
      <div class="mapediting-options stack-narrow">
        {isDrawn && (
          <Choice
            label="Cells become"
            options={[
              { value: "occupied", label: "Occupied" },
              { value: "free", label: "Free" },
              { value: "unknown", label: "Unknown" },
            ]}
            {...selected(mapEditing.state)}
          />
        )}
        {now === "keepout" && (
          <Choice
            label="The zone"
            options={[
              { value: "forbid", label: "Is forbidden" },
              { value: "allow", label: "Is allowed again" },
            ]}
            value={mapEditing.allows.value ? "allow" : "forbid"}
            onChange={(value) => {
              mapEditing.allows.value = value === "allow";
            }}
          />
        )}
        {now === "speed" && (
          <Slider
            label="Limit"
            sentence="Value of the speed filter’s mask: percent of the robot’s greatest speed with type 1, base 0 and multiplier 1. 0 removes the limit."
            unit="%"
            {...bound(mapEditing.limit)}
            initial={50}
            low={0}
            high={100}
            step={1}
          />
        )}
        {isArea && (
          <Choice
            label="Shape"
            options={[
              { value: "rectangle", label: "Rectangle" },
              { value: "free", label: "Freehand" },
            ]}
            value={mapEditing.isFreehand.value ? "free" : "rectangle"}
            onChange={(value) => {
              mapEditing.isFreehand.value = value === "free";
            }}
          />
        )}
        {(now === "brush" || now === "line") && (
          <Slider
            label="Width"
            sentence="Width of the brush and of lines; the keys [ and ] change it."
            unit="m"
            {...bound(mapEditing.width)}
            initial={0.1}
            low={0.01}
            high={WIDEST_M}
            step={0.01}
          />
        )}
      </div>
    </div>
  );
}

const DEGREES = 180 / Math.PI;

/** Specks and the heading of the whole map. */
export function WholeMap({ store }: { readonly store: Store }) {
  const cells = useSignal(3);
  const { turn } = mapEditingOf(store);
  const degrees = (turn.value ?? 0) * DEGREES;
  useEffect(
    () => () => {
      turn.value = null;
    },
    [turn],
  );
  const rotate = (angle: number): void => {
    turn.value = null;
    store.send({ type: "map_edit", op: "rotate", angle });
  };
  return (
    <div class="stack-narrow">
      <div class="mapediting-row">
        <Slider
          label="Specks"
          sentence="Groups of at most this many occupied cells become free."
          unit="cells"
          {...bound(cells)}
          initial={3}
          low={1}
          high={50}
          step={1}
        />
        <Button icon="erase" onClick={() => store.send({ type: "map_edit", op: "despeckle", value: cells.peek() })}>
          Remove specks
        </Button>
      </div>
      <div class="mapediting-row">
        <Slider
          label="Turn"
          sentence="The dashed frame shows the map after the turn about its origin, counter-clockwise."
          unit="°"
          value={degrees}
          initial={0}
          low={-180}
          high={180}
          step={0.5}
          onInput={(value) => {
            turn.value = value === 0 ? null : value / DEGREES;
          }}
        />
        <div class="actions">
          <Button icon="redo" disabled={degrees === 0} onClick={() => rotate(turn.peek() ?? 0)}>
            Turn
          </Button>
          <Button onClick={() => rotate(Math.PI / 2)}>90° left</Button>
          <Button onClick={() => rotate(-Math.PI / 2)}>90° right</Button>
        </div>
      </div>
    </div>
  );
}
