/** Requests about the parameters of localization as the yaml of an AMCL. Each rejects with the server's sentence. */

import { ask, fetched } from "../../wire/ask";
import type { AmclParameters } from "../../wire/http";

export type { AmclParameters };

export const readAmclYaml = (file: File): Promise<AmclParameters> =>
  ask("PUT /api/localization/parameters", {}, { file });

/** Parameters as the yaml of an AMCL. */
export async function amclYaml({ values, layout, others }: Omit<AmclParameters, "notes">): Promise<Blob> {
  const headers = { "Content-Type": "application/json" };
  const wanted = { method: "POST", headers, body: JSON.stringify({ ...others, ...values }) };
  return (await fetched(`/api/localization/amcl.yaml?layout=${layout}`, wanted)).blob();
}
