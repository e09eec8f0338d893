/** The parameters of the next job on a log, by group. */

import type { ComponentChildren } from "preact";
import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { Button } from "../../../ui/Button";
import type { JobParameters } from "./jobParameters";

interface DetailsProps {
  readonly parameters: JobParameters;
  /** Object with these parameters. */
  readonly name: string;
  /** The titles of the groups. */
  readonly titles: Readonly<Record<string, string>>;
  /** Figures of groups, above their rows. */
  readonly figures?: Readonly<Record<string, ComponentChildren>>;
  readonly children?: ComponentChildren;
}

export function ParameterDetails({ parameters, name, titles, figures = {}, children }: DetailsProps) {
  const table = parameters.table.value;
  const count = Object.keys(parameters.changed()).length;
  const groups = [...new Set(table.map((row) => row.group))];
  void parameters.values.value;
  return (
    <details class="slam-parameters" onToggle={(event) => event.currentTarget.open && void parameters.load()}>
      <summary>
        Parameters of {name}
        {count > 0 && ` (${count} changed)`}
      </summary>
      {table.length === 0 && <p class="quiet">Loading …</p>}
      {groups.map((group) => (
        <section key={group} aria-label={titles[group] ?? group}>
          <h3>{titles[group] ?? group}</h3>
          {figures[group]}
          <ParameterRows
            rows={table.filter((row) => row.group === group)}
            values={parameters.values}
            set={parameters.set}
          />
        </section>
      ))}
      {children}
      {count > 0 && (
        <Button kind="quiet" icon="restart" onClick={parameters.reset}>
          Reset to defaults
        </Button>
      )}
    </details>
  );
}
