/** The errors of one trajectory of a log against another, computed by the server. */

import { ask } from "../../../wire/ask";
import type { ErrorStatistics, SeriesAnswer, TrajectoryErrors } from "../../../wire/http";

export const STATISTICS = ["rmse", "mean", "median", "std", "min", "max"] as const;

/** The rows of the table: quantity, unit, and the figures in that unit; angles in degrees. */
export function rowsOf({
  absolute,
  relative,
}: TrajectoryErrors): readonly (readonly [string, string, readonly number[]])[] {
  const metres = (statistics: ErrorStatistics): number[] => STATISTICS.map((name) => statistics[name]);
  const degrees = (statistics: ErrorStatistics): number[] =>
    STATISTICS.map((name) => (statistics[name] * 180) / Math.PI);
  const over = `over ${relative.delta} ${relative.unit}`;
  return [
    ["Absolute", "m", metres(absolute.translation_m)],
    ["Absolute", "°", degrees(absolute.rotation_rad)],
    [`Relative, ${over}`, "m", metres(relative.translation_m)],
    [`Relative, ${over}`, "°", degrees(relative.rotation_rad)],
  ];
}

/** The errors over time for a plot, with translation and rotation separate. */
export function errorSeries(errors: TrajectoryErrors, which: "absolute" | "relative"): SeriesAnswer {
  const { times, translation_m, rotation_rad } = errors.series[which];
  return {
    topic: `${which} error`,
    type: "",
    samples: times.length,
    gaps: [],
    times,
    columns: [
      { label: "translation", unit: "m", plot: `${which} translation error`, values: translation_m },
      {
        label: "rotation",
        unit: "°",
        plot: `${which} rotation error`,
        values: rotation_rad.map((angle) => (angle * 180) / Math.PI),
      },
    ],
  };
}

/** Add a TUM file to the log of a session as a trajectory under its name. Rejects with the server's sentence. */
export async function addTrajectory(session: string, file: File): Promise<string> {
  const name = file.name.replace(/\.(tum|txt|csv)$/i, "").slice(0, 80) || "trajectory";
  const names = { session_id: session, name };
  return (await ask("PUT /api/sessions/{session_id}/trajectories/{name}", names, { body: file })).name;
}
