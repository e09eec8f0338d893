/** The other map of a comparison: labels, and requests to the server. */

import { readable } from "../../../tools/parameters/parameters";
import { written } from "../../../ui/numbers";
import type { Compared, Parameter, Value, Values } from "../../../wire/protocol";
import { trajectoryLabel } from "../library/describeLog";

/** How the other map differs: saved parameters, other poses, or another log. */
export type Kind = "settings" | "poses" | "log";

/** The other map, as in the body of `PUT /api/sessions/{id}/compare`. */
export interface Other {
  readonly values?: Values;
  readonly trajectory?: string | null;
  readonly log?: string | null;
  readonly topic?: string | null;
}

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

const address = (session: string): string => `/api/sessions/${encodeURIComponent(session)}/compare`;

const AWAY = "The server does not answer.";

async function refusal(answer: Response): Promise<string> {
  try {
    return ((await answer.json()) as { message: string }).message;
  } catch {
    return `The server answered ${answer.status}.`;
  }
}

/** Start or change the comparison; resolves to an error message, or null. */
export async function compareWith(session: string, other: Other): Promise<string | null> {
  try {
    const headers = { "Content-Type": "application/json" };
    const answer = await fetch(address(session), { method: "PUT", headers, body: JSON.stringify(other) });
    return answer.ok ? null : await refusal(answer);
  } catch {
    return AWAY;
  }
}

/** End the comparison; resolves to an error message, or null. */
export async function endComparison(session: string): Promise<string | null> {
  try {
    const answer = await fetch(address(session), { method: "DELETE" });
    return answer.ok ? null : await refusal(answer);
  } catch {
    return AWAY;
  }
}
