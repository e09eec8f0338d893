import { expect, test } from "vitest";
import { timeLabels } from "./plotParts";

test("times on an axis have the decimals that tell them apart", () => {
  expect(timeLabels([0, 60, 120])).toEqual(["0:00", "1:00", "2:00"]);
  expect(timeLabels([59.8, 59.9, 60])).toEqual(["0:59.8", "0:59.9", "1:00.0"]);
  expect(timeLabels([1.25, 1.27])).toEqual(["0:01.25", "0:01.27"]);
  expect(timeLabels([-0.5, 0])).toEqual(["−0:00.5", "0:00.0"]);
});
