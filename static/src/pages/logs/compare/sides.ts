/** The other map of a comparison: labels, and requests to the server. */

import { readable } from "../../../tools/parameters/parameters";
import { written } from "../../../ui/numbers";
import { ask } from "../../../wire/ask";
import type { ComparedMap } from "../../../wire/http";
import type { Compared, Parameter, Value, Values } from "../../../wire/protocol";
import { trajectoryLabel } from "../library/describeLog";

/** How the other map differs: saved parameters, other poses, or another log. */
export type Kind = "settings" | "poses" | "log";

export function kindOf(compared: Compared): Kind {
  if (compared.log) return "log";
  return Object.keys(compared.values).length > 0 ? "settings" : "poses";
}

/** Short labels of A and B for the corners of the picture. */
export function names(compared: Compared, trajectory: string, title: string): { a: string; b: string } {
  const poses = trajectoryLabel(compared.trajectory ?? "");
  switch (kindOf(compared)) {
    case "log":
      return { a: compared.title ?? "", b: title };
    case "poses":
      return { a: poses, b: trajectoryLabel(trajectory) };
    case "settings":
      return { a: "saved settings", b: "current settings" };
  }
}

interface Differing {
  readonly name: string;
  readonly label: string;
  readonly a: string;
  readonly b: string;
}

/** The parameters in which A and B differ. */
export function differing(table: readonly Parameter[], compared: Compared, values: Values): readonly Differing[] {
  const text = (row: Parameter, value: Value): string => {
    if (typeof value === "boolean") return value ? "on" : "off";
    if (typeof value === "string") return readable(value);
    return `${written(value, 3).replace(/\.?0+$/, "")}${row.unit ? ` ${row.unit}` : ""}`;
  };
  return table.flatMap((row) => {
    const a = compared.values[row.name];
    const b = values[row.name];
    if (a === undefined || b === undefined || a === b) return [];
    return [{ name: row.name, label: row.label, a: text(row, a), b: text(row, b) }];
  });
}

/** The error message of a request that is refused, or null. */
const refusalOf = (request: Promise<unknown>): Promise<string | null> =>
  request.then(
    () => null,
    (error: Error) => error.message,
  );

/** Start or change the comparison; resolves to an error message, or null. */
export const compareWith = (session: string, body: ComparedMap): Promise<string | null> =>
  refusalOf(ask("PUT /api/sessions/{session_id}/compare", { session_id: session }, { body }));

/** End the comparison; resolves to an error message, or null. */
export const endComparison = (session: string): Promise<string | null> =>
  refusalOf(ask("DELETE /api/sessions/{session_id}/compare", { session_id: session }));
