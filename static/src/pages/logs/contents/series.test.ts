import { describe, expect, it } from "vitest";
import { scanAtTime } from "./series";

describe("the scans that are in the map at a time", () => {
  it("are those up to it", () => {
    const each = { stamps: [0, 0.1, 0.2, 0.3], every: 1 };
    expect([-1, 0, 0.05, 0.1, 0.25, 9].map((seconds) => scanAtTime(each, seconds, 4))).toEqual([0, 1, 1, 2, 3, 4]);
  });

  it("are interpolated between the stamps that the page has", () => {
    const tenth = { stamps: [0, 1, 2], every: 10 };
    expect([0, 0.55, 1, 1.99, 2.5].map((seconds) => scanAtTime(tenth, seconds, 25))).toEqual([1, 6, 11, 20, 21]);
  });
});
