/** The errors of one trajectory of a log against another one, as the server computes them. */

import type { SeriesOfTopic } from "../contents/series";

export interface Statistics {
  readonly rmse: number;
  readonly mean: number;
  readonly median: number;
  readonly std: number;
  readonly min: number;
  readonly max: number;
}

export interface Figures {
  readonly translation_m: Statistics;
  readonly rotation_rad: Statistics;
}

interface Course {
  readonly times: readonly number[];
  readonly translation_m: readonly number[];
  readonly rotation_rad: readonly number[];
}

export interface TrajectoryErrors {
  readonly pairs: number;
  readonly alignment: { readonly x: number; readonly y: number; readonly theta: number; readonly scale: number };
  readonly absolute: Figures;
  readonly relative: Figures & { readonly delta: number; readonly unit: string; readonly pairs: number };
  readonly series: { readonly absolute: Course; readonly relative: Course };
  readonly paths: {
    readonly reference: readonly (readonly [number, number])[];
    readonly estimate: readonly (readonly [number, number])[];
    readonly errors_m: readonly number[];
  };
}

export const STATISTICS = ["rmse", "mean", "median", "std", "min", "max"] as const;

/** The rows of the table: what, its unit, and the figures in that unit; angles in degrees. */
export function rowsOf({
  absolute,
  relative,
}: TrajectoryErrors): readonly (readonly [string, string, readonly number[]])[] {
  const metres = (one: Statistics): number[] => STATISTICS.map((name) => one[name]);
  const degrees = (one: Statistics): number[] => STATISTICS.map((name) => (one[name] * 180) / Math.PI);
  const over = `over ${relative.delta} ${relative.unit}`;
  return [
    ["Absolute", "m", metres(absolute.translation_m)],
    ["Absolute", "°", degrees(absolute.rotation_rad)],
    [`Relative, ${over}`, "m", metres(relative.translation_m)],
    [`Relative, ${over}`, "°", degrees(relative.rotation_rad)],
  ];
}

/** The courses of the errors for a plot: translation and rotation each in one of its own. */
export function courseOf(errors: TrajectoryErrors, which: "absolute" | "relative"): SeriesOfTopic {
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

/** A TUM file is added to the log of a session as a trajectory under its own name. Throws an error with the server's message. */
export async function addTrajectory(session: string, file: File): Promise<string> {
  const name = file.name.replace(/\.(tum|txt|csv)$/i, "").slice(0, 80) || "trajectory";
  const address = `/api/sessions/${encodeURIComponent(session)}/trajectories/${encodeURIComponent(name)}`;
  const answer = await fetch(address, { method: "PUT", body: file });
  const body: unknown = await answer.json();
  if (!answer.ok) throw new Error((body as { message?: string }).message ?? "The trajectory was refused.");
  return (body as { name: string }).name;
}
