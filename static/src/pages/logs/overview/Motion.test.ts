import { expect, test } from "vitest";
import type { SeriesColumn } from "../../../wire/http";
import { motionOf } from "./Overview";

const column = (label: string, values: (number | null)[], unit = "m/s"): SeriesColumn => ({
  label,
  unit,
  plot: label,
  values,
});

const labels = (columns: readonly SeriesColumn[]): string[] => motionOf(columns).map(({ column }) => column.label);

test("a log with times has rates, one without has steps", () => {
  const steps = [column("pose step", [0, 0.1]), column("turn", [0, 0.2]), column("returns", [90, 100], "%")];
  expect(labels([column("speed", [0, 1]), column("turn rate", [0, 2]), ...steps])).toEqual([
    "speed",
    "turn rate",
    "returns",
  ]);
  expect(labels([column("speed", [null, null]), ...steps])).toEqual(["pose step", "turn", "returns"]);
});

test("what never changes is not plotted", () => {
  expect(
    labels([column("speed", [0, 0, null]), column("pose step", [0, 0]), column("returns", [50, 60], "%")]),
  ).toEqual(["returns"]);
  expect(labels([])).toEqual([]);
});
