import { expect, test } from "vitest";
import { Moments } from "./moments";

const at = (minute: number, second = 0): Date => new Date(2026, 0, 31, 9, minute, second);

test("the two files of a pair have one name, and the next pair another", () => {
  const moments = new Moments();
  expect(moments.next("a", "pgm", at(5))).toBe("2026-01-31_09-05-00");
  expect(moments.next("a", "yaml", at(7))).toBe("2026-01-31_09-05-00");
  expect(moments.next("a", "yaml", at(7, 30))).toBe("2026-01-31_09-07-30");
  expect(moments.next("a", "pgm", at(8))).toBe("2026-01-31_09-07-30");
});

test("a file that is taken twice begins a new pair, and so does one much later", () => {
  const moments = new Moments();
  moments.next("a", "pgm", at(5));
  const second = moments.next("a", "pgm", at(6));
  expect(second).toBe("2026-01-31_09-06-00");
  expect(moments.next("a", "yaml", at(7))).toBe(second);
  moments.next("a", "pgm", at(20));
  expect(moments.next("a", "yaml", at(31))).toBe("2026-01-31_09-31-00");
});

test("pairs that begin within one second have different names", () => {
  const moments = new Moments();
  const names = [0, 1, 2].map(() => {
    const name = moments.next("a", "pgm", at(5));
    expect(moments.next("a", "yaml", at(5))).toBe(name);
    return name;
  });
  expect(names).toEqual(["2026-01-31_09-05-00", "2026-01-31_09-05-01", "2026-01-31_09-05-02"]);
  expect(moments.next("a", "pgm", at(5, 1))).toBe("2026-01-31_09-05-03");
});

test("the pairs of two sessions have different names", () => {
  const moments = new Moments();
  const first = moments.next("a", "pgm", at(5));
  const second = moments.next("b", "yaml", at(5));
  expect(second).not.toBe(first);
  moments.next("b", "pgm", at(5));
  expect([first, second]).not.toContain(moments.next("a", "yaml", at(5)));
});
