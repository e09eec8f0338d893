/** Plotted fields of messages: which ones, what is computed from them, and their values in common rows. */

import type { SeriesAnswer, SeriesColumn, TopicFieldsAnswer } from "../../../wire/http";
import type { Span } from "../contents/series";

export type Made = "value" | "derivative" | "average";

/** A plotted field. */
export interface Chosen {
  readonly topic: string;
  /** Its path in the message. */
  readonly field: string;
  readonly made: Made;
  /** Window of the moving average, s. */
  readonly window: number;
}

/** The speed along the poses, available for a log with times. */
export const SPEED: Pick<Chosen, "topic" | "field"> = { topic: "(scans)", field: "speed" };

/** Names of the series that are computed from a log. */
export const COMPUTED: Readonly<Record<string, string>> = {
  speed: "Distance between the poses of two consecutive scans by the time between them",
  "turn rate": "Change of heading between two consecutive scans by the time between them, counter-clockwise",
  turn: "Change of heading between two consecutive scans, counter-clockwise",
  "pose step": "Distance between the poses of two consecutive scans: a jump of the poses is a peak",
  returns: "Share of a scan’s beams that measured a range",
  interval: "Time between two consecutive scans: a gap of the recording is a peak",
  entropy: "Entropy of the observed cells of the map after each scan",
  "cells changed": "Cells that a scan changed between unknown, free and occupied",
  contradicted: "Share of a scan’s readings that end in a free cell of the whole log’s map, or pass an occupied one",
  "relative error distance":
    "Distance by which two trajectories differ over 1 m; the two that Trajectories compares first",
  "relative error angle": "Angle by which two trajectories differ over 1 m; the two that Trajectories compares first",
  "odometry residual distance": "Distance by which the corrected poses miss the motion that was measured between two",
  "odometry residual angle": "Angle by which the corrected poses miss the motion that was measured between two",
  "loop residual distance": "The greatest distance by which the poses miss a loop that ends here",
  "loop residual angle": "The greatest angle by which the poses miss a loop that ends here",
};

export const WINDOWS = [0.2, 1, 5, 20] as const;

export const keyOf = ({ topic, field }: Pick<Chosen, "topic" | "field">): string => `${topic} ${field}`;

/** The plotted fields with one added, as it is in the messages; unchanged if it is among them. */
export function withField(chosen: readonly Chosen[], field: Pick<Chosen, "topic" | "field">): readonly Chosen[] {
  if (chosen.some((other) => keyOf(other) === keyOf(field))) return chosen;
  return [...chosen, { ...field, made: "value", window: 1 }];
}

/** The description of a field in a legend. */
export function labelOf(chosen: Chosen): string {
  if (chosen.made === "derivative") return `d/dt ${keyOf(chosen)}`;
  return chosen.made === "average" ? `${keyOf(chosen)}, mean of ${chosen.window} s` : keyOf(chosen);
}

/** The fields whose topic and path contain every word of a text, ignoring case; at most `most`. */
export function matching(
  topics: readonly TopicFieldsAnswer[],
  text: string,
  most: number,
): readonly Pick<Chosen, "topic" | "field">[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const matches: Pick<Chosen, "topic" | "field">[] = [];
  for (const { topic, fields } of topics) {
    for (const field of fields) {
      const name = `${topic} ${field}`.toLowerCase();
      if (!words.every((word) => name.includes(word))) continue;
      matches.push({ topic, field });
      if (matches.length === most) return matches;
    }
  }
  return matches;
}

/** A column with the gaps of its topic. */
export interface PlottedColumn extends SeriesColumn {
  readonly gaps?: readonly Span[];
}

/** Values of one or several topics in common rows of time. */
export interface Plotted extends Pick<SeriesAnswer, "topic" | "times" | "gaps"> {
  readonly columns: readonly PlottedColumn[];
}

export interface Found {
  readonly chosen: Chosen;
  readonly series: SeriesAnswer;
}

const column = ({ chosen, series }: Found, values: (number | null)[]): PlottedColumn => ({
  label: labelOf(chosen),
  unit: series.columns[0]?.unit ?? "",
  plot: "",
  values,
  gaps: series.gaps,
});

/** Several fields at the times of all; null where a field has no value at a time. */
export function joined(inputs: readonly Found[]): Plotted {
  const times = [...new Set(inputs.flatMap(({ series }) => series.times))].sort((a, b) => a - b);
  const place = new Map(times.map((time, n) => [time, n]));
  const columns = inputs.map((line) => {
    const values: (number | null)[] = new Array(times.length).fill(null);
    line.series.times.forEach((time, n) => {
      values[place.get(time) ?? 0] ??= line.series.columns[0]?.values[n] ?? null;
    });
    return column(line, values);
  });
  return { topic: "", times, gaps: [], columns };
}

/** Several fields at the times of the one with a key; the others are interpolated linearly between their samples. */
export function paired(inputs: readonly Found[], key: string): Plotted | null {
  const across = inputs.find(({ chosen }) => keyOf(chosen) === key);
  if (!across) return null;
  const { times } = across.series;
  const columns = inputs.map((line) => {
    const own = line === across;
    return column(
      line,
      own ? [...(line.series.columns[0]?.values ?? [])] : times.map((time) => valueAt(line.series, time)),
    );
  });
  return { topic: "", times, gaps: [], columns };
}

/** The value of a series' first column at a time, interpolated linearly; null beyond its ends and in gaps. */
export function valueAt({ times, columns, gaps }: SeriesAnswer, time: number): number | null {
  const values = columns[0]?.values ?? [];
  let low = 0; // the first sample after the time
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= time) low = middle + 1;
    else high = middle;
  }
  const [t0, t1] = [times[low - 1], times[low]];
  const [a, b] = [values[low - 1] ?? null, values[low] ?? null];
  if (t0 === undefined || a === null) return null;
  if (t0 === time) return a;
  if (t1 === undefined || b === null || gaps.some(([from, to]) => time > from && time < to)) return null;
  return a + ((time - t0) / (t1 - t0)) * (b - a);
}

/**
 * The plotted values as CSV: the time in s, in UTC as well if the log's clock gives it, and one column for each field;
 * empty where a field has no value. `start` is the time of the log's first scan, s since 1970, or null.
 */
export function csvOf({ times, columns }: Plotted, start: number | null): string {
  const quoted = (text: string): string => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const utc = (time: number): string[] =>
    start === null ? [] : [new Date(Math.round((start + time) * 1000)).toISOString()];
  const head = [
    "time_s",
    ...(start === null ? [] : ["time_utc"]),
    ...columns.map(({ label, unit }) => quoted(unit ? `${label} (${unit})` : label)),
  ];
  const rows = times.map((time, n) => [time, ...utc(time), ...columns.map(({ values }) => values[n] ?? "")].join(","));
  return `${[head.join(","), ...rows].join("\n")}\n`;
}
