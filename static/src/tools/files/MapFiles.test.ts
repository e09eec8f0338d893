import { expect, test } from "vitest";
import { MapSnapshots } from "./MapFiles";

const at = (minute: number, second = 0): Date => new Date(2026, 0, 31, 9, minute, second);

test("the two files of a pair have one name, and the next pair another", () => {
  const snapshots = new MapSnapshots();
  expect(snapshots.next("a", "pgm", at(5))).toBe("2026-01-31_09-05-00");
  expect(snapshots.next("a", "yaml", at(7))).toBe("2026-01-31_09-05-00");
  expect(snapshots.next("a", "yaml", at(7, 30))).toBe("2026-01-31_09-07-30");
  expect(snapshots.next("a", "pgm", at(8))).toBe("2026-01-31_09-07-30");
});

test("a file that is taken twice begins a new pair, and so does one much later", () => {
  const snapshots = new MapSnapshots();
  snapshots.next("a", "pgm", at(5));
  const second = snapshots.next("a", "pgm", at(6));
  expect(second).toBe("2026-01-31_09-06-00");
  expect(snapshots.next("a", "yaml", at(7))).toBe(second);
  snapshots.next("a", "pgm", at(20));
  expect(snapshots.next("a", "yaml", at(31))).toBe("2026-01-31_09-31-00");
});

test("pairs that begin within one second have different names", () => {
  const snapshots = new MapSnapshots();
  const names = [0, 1, 2].map(() => {
    const name = snapshots.next("a", "pgm", at(5));
    expect(snapshots.next("a", "yaml", at(5))).toBe(name);
    return name;
  });
  expect(names).toEqual(["2026-01-31_09-05-00", "2026-01-31_09-05-01", "2026-01-31_09-05-02"]);
  expect(snapshots.next("a", "pgm", at(5, 1))).toBe("2026-01-31_09-05-03");
});

test("the pairs of two sessions have different names", () => {
  const snapshots = new MapSnapshots();
  const first = snapshots.next("a", "pgm", at(5));
  const second = snapshots.next("b", "yaml", at(5));
  expect(second).not.toBe(first);
  snapshots.next("b", "pgm", at(5));
  expect([first, second]).not.toContain(snapshots.next("a", "yaml", at(5)));
});
