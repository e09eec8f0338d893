/** The path of the lab's robot: its goal, how it is planned and driven, and scenes that show why it is as it is. */

import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { KINDS } from "../../wire/kinds";
import { ParameterRows } from "../parameters/ParameterRows";
import { PathNumbers } from "./PathNumbers";
import { Scenes } from "./Scenes";
import { OverChoice, Tools } from "./Tools";
import { useCostmap } from "./useCostmap";
import { WhyCost } from "./WhyCost";
import "./navigation.css";

const ROWS = ["allow_unknown", "use_astar", "lookahead_dist", "desired_linear_vel", "tolerance"];

/** The rows of the parameters of these names, in this order. */
export function useRows(store: Store, names: readonly string[]) {
  const table = store.hello.value?.navigation;
  return useMemo(() => names.flatMap((name) => table?.filter((row) => row.name === name) ?? []), [table, names]);
}

export function PathGroup({ store }: { readonly store: Store }) {
  useCostmap(store);
  const rows = useRows(store, ROWS);
  const set = useMemo(
    () => (name: string, value: number | string | boolean) => store.setPart("costmap", { [name]: value }),
    [store],
  );
  if (store.navigation.costmap.value?.is_on !== true) return <Begin store={store} />;
  return (
    <div class="navigation">
      <Tools store={store} />
      <Outcome store={store} />
      {store.navigation.lastTool.value === "cost" && <WhyCost store={store} />}
      {isDriven(store) && <Scenes store={store} />}
      <OverChoice store={store} />
      <div class="navigation-settings">
        <ParameterRows rows={rows} values={store.navigation.values.values} set={set} />
      </div>
      <End store={store} />
    </div>
  );
}

/** Whether the robot can drive along the path: that of a log cannot. */
const isDriven = (store: Store): boolean => KINDS[store.hello.value?.kind ?? ""]?.isDriven ?? false;

/** A button that begins the costmap after the user has ended it. */
export function Begin({ store }: { readonly store: Store }) {
  if (!store.navigation.isEnded.value) return <p class="navigation-note">Computing the costmap …</p>;
  const begin = (): void => {
    store.navigation.isEnded.value = false;
  };
  return (
    <Button kind="primary" onClick={begin}>
      Make the costmap
    </Button>
  );
}

export function End({ store }: { readonly store: Store }) {
  return (
    <Button
      kind="quiet"
      onClick={() => {
        store.navigation.isEnded.value = true;
        store.send({ type: "costmap", value: false });
      }}
    >
      End the costmap
    </Button>
  );
}

function Outcome({ store }: { readonly store: Store }) {
  const path = store.navigation.path.value;
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
          <Button kind="quiet" onClick={() => store.setGoal(null)}>
            Remove goal
          </Button>
        </div>
      )}
    </div>
  );
}
