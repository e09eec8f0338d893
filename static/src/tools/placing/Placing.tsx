import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { inHand } from "../../ui/browser/media";
import { LiveRegion } from "../../ui/LiveRegion";
import { written } from "../../ui/numbers";
import type { MapTool } from "../costmap/state";
import { costmapOf } from "../costmap/state";

/** The effect of a click while a group of the costmap is open. */
const MAP_TOOL_HINTS: Readonly<Record<MapTool, string>> = {
  goal: "Click to set the goal, or drag it.",
  keepout: "Drag to paint where the robot must not go.",
  speed: "Drag to paint where the robot must be slower.",
  erase: "Drag over a painted zone to erase it.",
  cost: "Click a cell to ask for its cost.",
};

/** The button that deselects the editing tools, so that a click on the world places the robot. */
export function PlaceRobot({ store }: { readonly store: Store }) {
  const isOn = store.editing.tool.value === null;
  return (
    <Button kind="quiet" icon="robot" label="Move the robot" pressed={isOn} onClick={() => store.editing.take(null)} />
  );
}

/** One line on how the robot is placed and driven; empty while a tool edits the world. */
export function PlacingHint({ store }: { readonly store: Store }) {
  if (store.editing.tool.value !== null) return null;
  const tool = costmapOf(store).tool.value;
  if (tool !== null && costmapOf(store).costmap.value?.is_on) return <p class="hint">{inHand(MAP_TOOL_HINTS[tool])}</p>;
  return (
    <p class="hint">
      {inHand("Click to teleport the robot, drag it")}
      <span class="hint-keys">
        , or drive with <kbd>W</kbd> <kbd>A</kbd> <kbd>S</kbd> <kbd>D</kbd>
      </span>
    </p>
  );
}

/** Announces to screen readers where a click, a tap or Enter has sent the robot. */
export function RobotAnnouncement({ store }: { readonly store: Store }) {
  const sent = store.teleported.value;
  return (
    <LiveRegion
      text={sent ? `Robot moved to x ${written(sent.point[0], 1)} m, y ${written(sent.point[1], 1)} m` : ""}
    />
  );
}
