/** The rows of the mapper's parameter table that a panel shows, and their bounds. */

import type { Range } from "../../ui/numbers";
import type { Parameter, Values } from "../../wire/protocol";

/**
 * Whether a row is shown: it applies to the current model, kind of sensor or fit, and a choice has at least two options.
 */
export function isShown(row: Parameter, values: Values): boolean {
  if (row.kind === "choice" && row.choices.length < 2) return false;
  if (row.name === "fit_distance" && values.fit !== "ransac") return false;
  const model = values.model ?? values.kind;
  return row.only_for.length === 0 || (typeof model === "string" && row.only_for.includes(model));
}

/** Rows that have an effect only with the update per beam. */
const PER_BEAM: readonly string[] = ["hit_and_passed", "traversal"];

/** Whether a row has an effect: the clamp's limits only while it is on, some only with the update per beam. */
export function isEnabled(row: Parameter, values: Values): boolean {
  if (PER_BEAM.includes(row.name)) return values.update !== "per_scan";
  return !(values.clamp === false && (row.name === "log_odds_min" || row.name === "log_odds_max"));
}

const numeric = (values: Values, name: string, otherwise: number): number => {
  const value = values[name];
  return typeof value === "number" ? value : otherwise;
};

/** The bounds of a number row; for the step window narrowed so that p_free ≤ prior ≤ p_occ. */
export function boundsOf(row: Parameter, values: Values): Range {
  const range = { low: row.low, high: row.high, step: row.step };
  if (values.model !== "step_window") return range;
  const logit = (p: number): number => Math.log(p / (1 - p));
  const p = 1 / (1 + Math.exp(-numeric(values, "log_odds_prior", 0)));
  const inward = (value: number, up: boolean): number => {
    const steps = value / row.step;
    return (up ? Math.ceil(steps - 1e-9) : Math.floor(steps + 1e-9)) * row.step;
  };
  switch (row.name) {
    case "p_free":
      return { ...range, high: Math.min(row.high, inward(p, false)) };
    case "p_occ":
      return { ...range, low: Math.max(row.low, inward(p, true)) };
    case "log_odds_prior":
      return {
        ...range,
        low: Math.max(row.low, inward(logit(numeric(values, "p_free", 0.01)), true)),
        high: Math.min(row.high, inward(logit(numeric(values, "p_occ", 0.99)), false)),
      };
    default:
      return range;
  }
}

/** Choices whose label differs from their words: names of people, and a model by the name used in the lecture. */
const LABELS: Readonly<Record<string, string>> = {
  step_window: "step window in probabilities",
  moravec_elfes: "Moravec and Elfes 1985",
  bresenham: "Bresenham",
  amanatides_woo: "Amanatides and Woo",
};

/** The label of a choice: per_beam → per beam. */
export function readable(choice: string): string {
  return LABELS[choice] ?? choice.replaceAll("_", " ");
}

/** The number of rows whose value differs from the initial one. */
export function changedOf(rows: readonly Parameter[], values: Values): number {
  return rows.filter((row) => (values[row.name] ?? row.initial) !== row.initial).length;
}

export interface Group {
  readonly name: string;
  readonly rows: readonly Parameter[];
}

/** The shown rows by group, in the order of the table; empty groups are left out. */
export function grouped(table: readonly Parameter[], values: Values): readonly Group[] {
  const groups = new Map<string, Parameter[]>();
  for (const row of table) {
    if (!isShown(row, values)) continue;
    const rows = groups.get(row.group);
    if (rows) rows.push(row);
    else groups.set(row.group, [row]);
  }
  return [...groups].map(([name, rows]) => ({ name, rows }));
}
