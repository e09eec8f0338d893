/** What a log's map is compared with: in words, and as the server is told. */

import { readable } from "../../../tools/parameters/parameters";
import { written } from "../../../ui/numbers";
import type { Compared, Parameter, Value, Values } from "../../../wire/protocol";
import { trajectoryLabel } from "../describeLog";

/** What the other side has otherwise: parameters that are kept, other poses, or another log. */
export type Kind = "settings" | "poses" | "log";

/** The other side, as `PUT /api/sessions/{id}/compare` takes it. */
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

/** What A and B are, in a few words for a corner of the picture. */
export function names(compared: Compared, trajectory: string, title: string): { a: string; b: string } {
  const poses = trajectoryLabel(compared.trajectory ?? "");
  switch (kindOf(compared)) {
    case "log":
      return { a: compared.title ?? "", b: title };
    case "poses":
      return { a: poses, b: trajectoryLabel(trajectory) };
    case "settings":
      return { a: "as kept", b: "as set now" };
  }
}

interface Differing {
  readonly name: string;
  readonly label: string;
  readonly a: string;
  readonly b: string;
}

/** The parameters that A has otherwise than B. */
export function differing(table: readonly Parameter[], compared: Compared, values: Values): readonly Differing[] {
  const told = (row: Parameter, value: Value): string => {
    if (typeof value === "boolean") return value ? "on" : "off";
    if (typeof value === "string") return readable(value);
    return `${written(value, 3).replace(/\.?0+$/, "")}${row.unit ? ` ${row.unit}` : ""}`;
  };
  return table.flatMap((row) => {
    const a = compared.values[row.name];
    const b = values[row.name];
    if (a === undefined || b === undefined || a === b) return [];
    return [{ name: row.name, label: row.label, a: told(row, a), b: told(row, b) }];
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

/** Compare with another side; resolves to the sentence of what is in the way, or null. */
export async function compareWith(session: string, other: Other): Promise<string | null> {
  try {
    const headers = { "Content-Type": "application/json" };
    const answer = await fetch(address(session), { method: "PUT", headers, body: JSON.stringify(other) });
    return answer.ok ? null : await refusal(answer);
  } catch {
    return AWAY;
  }
}

/** Compare no longer; resolves to the sentence of what is in the way, or null. */
export async function compareNoMore(session: string): Promise<string | null> {
  try {
    const answer = await fetch(address(session), { method: "DELETE" });
    return answer.ok ? null : await refusal(answer);
  } catch {
    return AWAY;
  }
}
