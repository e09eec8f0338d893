/** Requests about the parameters of localization as the yaml of an AMCL. Each rejects with the server's sentence. */

import type { Values } from "../../wire/protocol";

/** What the yaml of an AMCL says, as far as it differs from the first values, and the names in it that are of no use. */
export async function readAmclYaml(
  file: File,
): Promise<{ readonly values: Values; readonly ignored: readonly string[] }> {
  const answer = await accepted(await fetch("/api/localization/parameters", { method: "PUT", body: file }));
  return (await answer.json()) as { values: Values; ignored: readonly string[] };
}

/** Parameters as the yaml of an AMCL. */
export async function amclYaml(values: Values): Promise<Blob> {
  const headers = { "Content-Type": "application/json" };
  const wanted = { method: "POST", headers, body: JSON.stringify(values) };
  return (await accepted(await fetch("/api/localization/amcl.yaml", wanted))).blob();
}

async function accepted(answer: Response): Promise<Response> {
  if (answer.ok) return answer;
  const { message } = (await answer.json()) as { message?: string };
  throw new Error(message ?? "The server refused it.");
}
