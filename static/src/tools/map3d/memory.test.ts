import { expect, test } from "vitest";
import { shareOf, sizeOf } from "./memory";

test("bytes have three digits and a unit", () => {
  expect([0, 999, 1000, 12_345, 999_400, 999_600, 2_500_000, 3e12].map(sizeOf)).toEqual([
    "0 B",
    "999 B",
    "1.00 kB",
    "12.3 kB",
    "999 kB",
    "1.00 MB",
    "2.50 MB",
    "3000 GB",
  ]);
});

test("a bar grows by the same length for each factor of ten", () => {
  const share = (bytes: number) => shareOf(bytes, 1e6);
  expect(share(1e6)).toBe(1);
  expect(share(1e5) - share(1e4)).toBeCloseTo(share(1e6) - share(1e5));
  expect([share(0), share(1000), shareOf(5, 5)]).toEqual([0, 0, 0]);
});
