import { expect, test } from "vitest";
import { Moments } from "./moments";

const at = (minute: number, second = 0): Date => new Date(2026, 0, 31, 9, minute, second);

test("the two files of a pair have one name, and the next pair another", () => {
  const moments = new Moments();
  expect(moments.next("pgm", at(5))).toBe("2026-01-31_09-05-00");
  expect(moments.next("yaml", at(7))).toBe("2026-01-31_09-05-00");
  expect(moments.next("yaml", at(7, 30))).toBe("2026-01-31_09-07-30");
  expect(moments.next("pgm", at(8))).toBe("2026-01-31_09-07-30");
});

test("a file that is taken twice begins a new pair, and so does one much later", () => {
  const moments = new Moments();
  moments.next("pgm", at(5));
  const second = moments.next("pgm", at(6));
  expect(second).toBe("2026-01-31_09-06-00");
  expect(moments.next("yaml", at(7))).toBe(second);
  moments.next("pgm", at(20));
  expect(moments.next("yaml", at(31))).toBe("2026-01-31_09-31-00");
});
