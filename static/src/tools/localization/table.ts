/** The server's table of localization parameters. */

import type { Parameter } from "../../wire/protocol";

/** Ask for it. Rejects where the server does not answer. */
export async function filterTable(): Promise<readonly Parameter[]> {
  const answer = await fetch("/api/localization/parameters");
  if (!answer.ok) throw new Error(`The server answered ${answer.status}.`);
  return ((await answer.json()) as { table: readonly Parameter[] }).table;
}
