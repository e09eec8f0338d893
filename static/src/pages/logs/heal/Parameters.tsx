/** The parameters of SLAM, by group, for the next job. */

import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { Button } from "../../../ui/Button";
import type { SlamParameters } from "./slamParameters";

const TITLES: Readonly<Record<string, string>> = {
  scans: "Scans",
  "front end": "Each scan with those before it",
  loops: "Loops",
  graph: "Graph",
  refinement: "Refinement",
};

export function Parameters({ parameters }: { readonly parameters: SlamParameters }) {
  const table = parameters.table.value;
  const count = Object.keys(parameters.changed()).length;
  const groups = [...new Set(table.map((row) => row.group))];
  void parameters.values.value;
  return (
    <details class="slam-parameters" onToggle={(event) => event.currentTarget.open && void parameters.load()}>
      <summary>Parameters of SLAM{count > 0 && ` (${count} changed)`}</summary>
      {table.length === 0 && <p class="quiet">Loading …</p>}
      {groups.map((group) => (
        <section key={group} aria-label={TITLES[group] ?? group}>
          <h3>{TITLES[group] ?? group}</h3>
          <ParameterRows
            rows={table.filter((row) => row.group === group)}
            values={parameters.values}
            set={parameters.set}
          />
        </section>
      ))}
      {count > 0 && (
        <Button kind="quiet" icon="restart" onClick={parameters.reset}>
          Reset to defaults
        </Button>
      )}
    </details>
  );
}
