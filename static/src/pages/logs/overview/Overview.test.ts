import { expect, test } from "vitest";
import { lengthOf } from "./Overview";

test("the length of a path is that of its steps", () => {
  expect(lengthOf({ poses: [] })).toBe(0);
  expect(
    lengthOf({
      poses: [
        [0, 0],
        [3, 4],
        [3, 5],
      ],
    }),
  ).toBe(6);
});
