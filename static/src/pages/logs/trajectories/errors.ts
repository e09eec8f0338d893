/** The errors of one trajectory of a log against another one, as the server computes them. */

import { ask } from "../../../wire/ask";
import type { ErrorStatistics, SeriesAnswer, TrajectoryErrors } from "../../../wire/http";
import type { TrajectoryInfo } from "../../../wire/messages";

export const STATISTICS = ["rmse", "mean", "median", "std", "min", "max"] as const;

/**
 * The pair that is compared at first: poses found from the scans as the reference, and the wheels beside them; never two
 * that are one path. Without such poses the first two paths; with only one path, its two names.
 */
export function firstPair(trajectories: readonly TrajectoryInfo[]): readonly [reference: string, estimate: string] {
  const paths = trajectories.filter(({ same_as }) => same_as === null);
  const found = paths.filter(({ from_scans }) => from_scans).at(-1);
  const others = paths.filter((path) => path !== found);
  const wheels = others.find(({ name, from_scans }) => !from_scans && /odom|wheel/i.test(name));
  const reference = found ?? paths[0];
  const estimate = (found && wheels) ?? others.find((other) => other !== reference) ?? trajectories[1];
  return [reference?.name ?? "", estimate?.name ?? ""];
}

/** The rows of the table: what, its unit, and the figures in that unit; angles in degrees. */
export function rowsOf({
  absolute,
  relative,
}: TrajectoryErrors): readonly (readonly [string, string, readonly number[]])[] {
  const metres = (one: ErrorStatistics): number[] => STATISTICS.map((name) => one[name]);
  const degrees = (one: ErrorStatistics): number[] => STATISTICS.map((name) => (one[name] * 180) / Math.PI);
  const over = `over ${relative.delta} ${relative.unit}`;
  return [
    ["Absolute", "m", metres(absolute.translation_m)],
    ["Absolute", "°", degrees(absolute.rotation_rad)],
    [`Relative, ${over}`, "m", metres(relative.translation_m)],
    [`Relative, ${over}`, "°", degrees(relative.rotation_rad)],
  ];
}

/** The errors over time for a plot: translation and rotation each in one of its own. */
export function errorSeries(errors: TrajectoryErrors, which: "absolute" | "relative"): SeriesAnswer {
  const { times, translation_m, rotation_rad } = errors.series[which];
  return {
    topic: `${which} error`,
    type: "",
    samples: times.length,
    gaps: [],
    times,
    columns: [
      { label: "translation", unit: "m", plot: `${which} error of the place`, values: translation_m },
      {
        label: "rotation",
        unit: "°",
        plot: `${which} error of the heading`,
        values: rotation_rad.map((angle) => (angle * 180) / Math.PI),
      },
    ],
  };
}

/** A TUM file is added to the log of a session as a trajectory under its own name. Rejects with the server's sentence. */
export async function addTrajectory(session: string, file: File): Promise<string> {
  const name = file.name.replace(/\.(tum|txt|csv)$/i, "").slice(0, 80) || "trajectory";
  const names = { session_id: session, name };
  return (await ask("PUT /api/sessions/{session_id}/trajectories/{name}", names, { body: file })).name;
}
