/** The path of the lab's robot: its goal, how it is planned and driven, and scenes that show why it is as it is. */

import { useMemo } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { KINDS } from "../../wire/kinds";
import type { PathMessage } from "../../wire/protocol";
import { Begin, End, useCostmap, useRows } from "../costmap/BeginEnd";
import { costmapOf } from "../costmap/state";
import { OverChoice, Tools } from "../costmap/Tools";
import { WhyCost } from "../costmap/WhyCost";
import { ParameterRows } from "../parameters/ParameterRows";
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
    <div class="navigation stack-narrow">
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

interface PathNumbersProps {
  /** The path; null before there is a goal. */
  readonly path: PathMessage | null;
}

/** Numbers of a path. Before there is a goal they are dashes, which show what a goal will tell. */
export function PathNumbers({ path }: PathNumbersProps) {
  const number = (value: number | null | undefined, digits: number, unit: string): string =>
    value === null || value === undefined ? `– ${unit}` : `${written(value, digits)} ${unit}`;
  const rows: [label: string, text: string][] = [["Path", number(path?.length, 1, "m")]];
  if (!path || path.travel_s !== null) rows.push(["Travel time", number(path?.travel_s, 1, "s")]);
  rows.push(["Cost", path ? Math.round(path.cost ?? 0).toLocaleString("en") : "–"]);
  rows.push(["Planned in", number(path?.plan_ms, 1, "ms")]);
  if (path && path.speed_limit !== null) rows.push(["Speed limit", path.speed_limit]);
  return (
    <dl class={`number-row${path ? "" : " awaited"}`}>
      {rows.map(([label, text]) => (
        <div key={label}>
          <dt>{label}</dt>
          <dd>{text}</dd>
        </div>
      ))}
    </dl>
  );
}
