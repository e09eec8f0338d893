/** The costmap of the lab's robot: its layers as sheets, their parameters, and the robot's outline. */

import { useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useMemo, useRef } from "preact/hooks";
import { CostCurve as Curve } from "../../render/chart/CostCurve";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { saveAs } from "../../ui/files/saveAs";
import type { Range } from "../../ui/numbers";
import { ParameterRows } from "../parameters/ParameterRows";
import { Begin, End, useCostmap, useRows } from "./BeginEnd";
import { CostFiles } from "./CostFiles";
import { Outline } from "./Outline";
import { Sheets } from "./Sheets";
import { costmapOf } from "./state";
import { OverChoice } from "./Tools";
import { WhyCost } from "./WhyCost";
import "./costmap.css";

const ROWS = [
  "map",
  "track_unknown_space",
  "clearing",
  "lifetime",
  "obstacle_max_range",
  "speed_filter",
  "speed_limits",
];
const INFLATION = ["inflation_radius", "cost_scaling_factor"];
/** A command has at most 64 KiB. */
const MOST_BYTES = 60_000;

interface CostmapGroupProps {
  readonly store: Store;
  /** Further settings of the layers. */
  readonly children?: ComponentChildren;
}

export function CostmapGroup({ store, children }: CostmapGroupProps) {
  useCostmap(store);
  const rows = useRows(store, ROWS);
  const inflation = useRows(store, INFLATION);
  const set = useMemo(
    () => (name: string, value: number | string | boolean) => store.setPart("costmap", { [name]: value }),
    [store],
  );
  const { costmap, values } = costmapOf(store);
  if (costmap.value?.is_on !== true) return <Begin store={store} />;
  return (
    <div class="navigation stack-narrow">
      <Sheets store={store} />
      <WhyCost store={store} />
      <OverChoice store={store} />
      <h2>Inflation</h2>
      <CostCurve store={store} />
      <div class="navigation-settings">
        <ParameterRows rows={inflation} values={values.values} set={set} />
      </div>
      <Outline store={store} />
      <h2>Layers</h2>
      <div class="navigation-settings">
        <ParameterRows rows={rows} values={values.values} set={set} />
        {children}
      </div>
      <h2>Nav2</h2>
      <Nav2 store={store} />
      <h2>Download the costs</h2>
      <CostFiles session={store.hello.value?.session ?? ""} strokes={costmap.value.keepout} />
      <End store={store} />
    </div>
  );
}

/** The parameters as a Nav2 parameter file, down and up. */
function Nav2({ store }: { readonly store: Store }) {
  const file = useRef<HTMLInputElement>(null);
  const answer = store.part("nav2").message;
  useSignalEffect(() => {
    const text = answer.value?.text ?? null;
    if (text === null) return;
    answer.value = null;
    saveAs("nav2_params.yaml", new Blob([text], { type: "application/yaml" }));
  });
  const upload = async (): Promise<void> => {
    const chosen = file.current?.files?.[0];
    if (file.current) file.current.value = "";
    if (!chosen) return;
    if (chosen.size > MOST_BYTES) {
      store.notice.value = {
        kind: "error",
        code: "nav2.too_large",
        message: `The parameter file has ${chosen.size} bytes; at most ${MOST_BYTES} are read.`,
      };
      return;
    }
    store.send({ type: "nav2", text: await chosen.text() });
  };
  return (
    <>
      <p class="navigation-note">
        The parameters as a Nav2 file: costmap, NavFn and Regulated Pure Pursuit. Nav2 has no layer with a lifetime: it
        is left out. Painted zones are filters with a mask of their own below: save its files beside the yaml.
      </p>
      <div class="actions">
        <Button icon="download" onClick={() => store.send({ type: "nav2" })}>
          Download yaml
        </Button>
        <Button icon="upload" onClick={() => file.current?.click()}>
          Load yaml
        </Button>
        <input
          ref={file}
          type="file"
          accept=".yaml,.yml"
          hidden
          aria-label="Nav2 parameter file"
          onChange={() => void upload()}
        />
      </div>
    </>
  );
}

/** The curve of the session's costs. */
export function CostCurve({ store }: { readonly store: Store }) {
  const state = costmapOf(store);
  const costmap = state.costmap.value;
  const values = state.values.values.value;
  const table = store.hello.value?.tables.costmap;
  const row = (name: string): Range => table?.find((one) => one.name === name) ?? { low: 0, high: 1, step: 0.1 };
  if (!costmap) return null;
  return (
    <Curve
      inscribed={costmap.inscribed_radius}
      circumscribed={costmap.circumscribed_radius}
      inflation={{
        inflation_radius: Number(values.inflation_radius),
        cost_scaling_factor: Number(values.cost_scaling_factor),
      }}
      ranges={{ inflation_radius: row("inflation_radius"), cost_scaling_factor: row("cost_scaling_factor") }}
      onChange={(name, value) => store.setPart("costmap", { [name]: value })}
    />
  );
}
