/** Requests about the parameters of localization as the yaml of an AMCL. Each rejects with the server's sentence. */

import type { Values } from "../../wire/protocol";

/** What the yaml of an AMCL says. */
export interface AmclParameters {
  /** Those that differ from the first values. */
  readonly values: Values;
  readonly layout: "nav2" | "ros1";
  /** What does not change where the robot is found: frames, topics, rates. It is kept in a yaml that is saved. */
  readonly others: Readonly<Record<string, unknown>>;
  /** Sentences on names that AMCL does not have. */
  readonly notes: readonly string[];
}

export async function readAmclYaml(file: File): Promise<AmclParameters> {
  const answer = await accepted(await fetch("/api/localization/parameters", { method: "PUT", body: file }));
  return (await answer.json()) as AmclParameters;
}

/** Parameters as the yaml of an AMCL. */
export async function amclYaml({ values, layout, others }: Omit<AmclParameters, "notes">): Promise<Blob> {
  const headers = { "Content-Type": "application/json" };
  const wanted = { method: "POST", headers, body: JSON.stringify({ ...others, ...values }) };
  return (await accepted(await fetch(`/api/localization/amcl.yaml?layout=${layout}`, wanted))).blob();
}

async function accepted(answer: Response): Promise<Response> {
  if (answer.ok) return answer;
  const { message } = (await answer.json()) as { message?: string };
  throw new Error(message ?? "The server refused it.");
}
