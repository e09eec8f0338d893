/** The server's table of localization parameters. */

import { ask } from "../../wire/ask";
import type { Parameter } from "../../wire/protocol";

/** Ask for it. Rejects where the server does not answer. */
export async function filterTable(): Promise<readonly Parameter[]> {
  return (await ask("GET /api/localization/parameters", {})).table;
}
