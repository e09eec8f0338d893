/** The path of the lab's robot: its goal, how it is planned and driven, and scenes that show why it is as it is. */

import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { KINDS } from "../../wire/kinds";
import { Begin, End } from "../costmap/BeginEnd";
import { costmapOf } from "../costmap/state";
import { OverChoice, Tools } from "../costmap/Tools";
import { useCostmap, useRows } from "../costmap/useCostmap";
import { WhyCost } from "../costmap/WhyCost";
import { ParameterRows } from "../parameters/ParameterRows";
import { PathNumbers } from "./PathNumbers";
import { Scenes } from "./Scenes";
import { pathOf } from "./state";
import "../costmap/costmap.css";

const ROWS = ["allow_unknown", "use_astar", "lookahead_dist", "desired_linear_vel", "tolerance"];

export function PathGroup({ store }: { readonly store: Store }) {
  useCostmap(store);
  const rows = useRows(store, ROWS);
  const set = useMemo(
    () => (name: string, value: number | string | boolean) => store.setPart("costmap", { [name]: value }),
    [store],
  );
  if (costmapOf(store).costmap.value?.is_on !== true) return <Begin store={store} />;
  return (
    <div class="navigation">
      <Tools store={store} />
      <Outcome store={store} />
      {costmapOf(store).lastTool.value === "cost" && <WhyCost store={store} />}
      {isDriven(store) && <Scenes store={store} />}
      <OverChoice store={store} />
      <div class="navigation-settings">
        <ParameterRows rows={rows} values={costmapOf(store).values.values} set={set} />
      </div>
      <End store={store} />
    </div>
  );
}

/** Whether the robot can drive along the path: that of a log cannot. */
const isDriven = (store: Store): boolean => KINDS[store.hello.value?.kind ?? ""]?.isDriven ?? false;

function Outcome({ store }: { readonly store: Store }) {
  const path = pathOf(store).path.value;
  const goal = path?.goal ?? null;
  const isRefused = goal !== null && path?.length === null;
  const drive = (drives: boolean): void => {
    const [x, y] = goal ?? [0, 0];
    store.send({ type: "goal", x, y, drives });
    if (drives) store.send({ type: "play" });
  };
  return (
    <div class={`navigation-outcome${isRefused ? " refused" : ""}`}>
      {!isRefused && <PathNumbers path={goal && path} />}
      <p role="status">{goal ? path?.reason : "There is no goal yet."}</p>
      {goal && path && (
        <div class="actions">
          {isDriven(store) && (
            <Button
              kind={path.drives ? undefined : "primary"}
              icon={path.drives ? "pause" : "play"}
              disabled={path.length === null && !path.drives}
              onClick={() => drive(!path.drives)}
            >
              {path.drives ? "Stop" : "Drive there"}
            </Button>
          )}
          <Button kind="quiet" onClick={() => pathOf(store).setGoal(null)}>
            Remove goal
          </Button>
        </div>
      )}
    </div>
  );
}
