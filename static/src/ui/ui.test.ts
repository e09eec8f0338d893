import { signal } from "@preact/signals";
import { describe, expect, it } from "vitest";
import { showAnswer } from "./browser/attempts";
import { keyedTab, sectionsOf } from "./dock/Dock";
import { clock, decimals, fromFraction, keyed, numberOf, signed, snap, toFraction, written } from "./numbers";
import { indexAt, keyedIndex, placeOf } from "./seek";

const WINDOW = { low: 0, high: 2, step: 0.05 };
const RANGE = { low: 0.5, high: 100, step: 0.1 };

describe("a slider's arithmetic", () => {
  it("snaps onto steps without leaving floating-point crumbs", () => {
    expect(snap(0.1499999, WINDOW)).toBe(0.15);
    expect(snap(0.1 + 0.2, WINDOW)).toBe(0.3);
    expect(snap(-1, WINDOW)).toBe(0);
    expect(snap(7, WINDOW)).toBe(2);
    expect(Object.is(snap(-0.001, { low: -3, high: 0, step: 0.05 }), 0)).toBe(true);
  });

  it("answers the keys of a range input", () => {
    expect(keyed("ArrowRight", false, 0.2, WINDOW)).toBe(0.25);
    expect(keyed("ArrowDown", false, 0.2, WINDOW)).toBe(0.15);
    expect(keyed("ArrowLeft", false, 0, WINDOW)).toBe(0);
    expect(keyed("ArrowRight", true, 0.2, WINDOW, 0.01)).toBe(0.21);
    expect(keyed("PageUp", false, 0.2, WINDOW)).toBe(0.7);
    expect(keyed("Home", false, 0.2, WINDOW)).toBe(0);
    expect(keyed("End", false, 0.2, WINDOW)).toBe(2);
    expect(keyed("a", false, 0.2, WINDOW)).toBeNull();
  });

  it("gives wide ranges a logarithmic track, and comes back to the value it left", () => {
    expect(toFraction(Math.sqrt(50), RANGE)).toBeCloseTo(0.5, 6);
    for (const value of [0.5, 3.3, 30, 81.9, 100]) expect(fromFraction(toFraction(value, RANGE), RANGE)).toBe(value);
    for (const value of [0, 0.05, 1.95, 2]) expect(fromFraction(toFraction(value, WINDOW), WINDOW)).toBe(value);
  });

  it("writes numbers for people", () => {
    expect(decimals(0.05)).toBe(2);
    expect(decimals(1)).toBe(0);
    expect(written(-0.4, 2)).toBe("−0.40");
    expect(written(-0.001, 2)).toBe("0.00");
    expect(numberOf("−0.40")).toBe(-0.4);
    expect(numberOf(" -0,4")).toBe(-0.4);
    expect(numberOf(" ")).toBeNaN();
    expect(numberOf("1 m")).toBeNaN();
    expect(signed(0.85)).toBe("+0.85");
    expect(signed(0)).toBe("0.00");
    expect(clock(3725)).toBe("1:02:05");
    expect(clock(65.9)).toBe("1:05");
  });
});

describe("a timeline's arithmetic", () => {
  it("finds the scan under the pointer and keeps to the ends", () => {
    expect(indexAt(50, 100, 910)).toBe(455);
    expect(indexAt(-5, 100, 910)).toBe(0);
    expect(indexAt(500, 100, 910)).toBe(910);
    expect(indexAt(5, 0, 910)).toBe(0);
    expect(placeOf(455, 910)).toBe(0.5);
    expect(placeOf(3, 0)).toBe(0);
  });

  it("steps by one, ten, a twentieth, and to the ends", () => {
    expect(keyedIndex("ArrowRight", false, 5, 910)).toBe(6);
    expect(keyedIndex("ArrowLeft", true, 5, 910)).toBe(0);
    expect(keyedIndex("PageUp", false, 5, 910)).toBe(51);
    expect(keyedIndex("End", false, 5, 910)).toBe(910);
    expect(keyedIndex("Home", false, 5, 910)).toBe(0);
    expect(keyedIndex("Tab", false, 5, 910)).toBeNull();
  });
});

describe("the keys of a dock's tabs", () => {
  it("go round, and to both ends", () => {
    expect(keyedTab("ArrowRight", 6, 7)).toBe(0);
    expect(keyedTab("ArrowLeft", 0, 7)).toBe(6);
    expect(keyedTab("ArrowDown", 2, 7)).toBe(3);
    expect(keyedTab("Home", 3, 7)).toBe(0);
    expect(keyedTab("End", 3, 7)).toBe(6);
    expect(keyedTab("Enter", 3, 7)).toBeNull();
  });
});

describe("the sections of a dock", () => {
  it("have the groups beside each other that name the same, and the badge of one of them", () => {
    const groups = [
      { id: "a", title: "A", purpose: "first" },
      { id: "b", title: "B", section: "S" },
      { id: "c", title: "C", section: "S", badge: "2" },
      { id: "d", title: "D", section: "T" },
    ];
    expect(sectionsOf(groups).map(({ id, title, hint, badge }) => [id, title, hint, badge])).toEqual([
      ["a", "A", "first", null],
      ["b", "S", "B, C", "2"],
      ["d", "D", null, null],
    ]);
  });
});

describe("the answer to a request of an effect", () => {
  it("is shown in place of an earlier failure, and a refusal of a request that was ended is not shown", async () => {
    const failure = signal<string | null>("The server answered 500.");
    const shown: string[] = [];
    showAnswer(
      () => Promise.resolve("new"),
      failure,
      (answer) => shown.push(answer),
    );
    await Promise.resolve();
    expect([shown, failure.value]).toEqual([["new"], null]);
    const end = showAnswer(
      (ending) => refusedAtEnd(ending, "ended"),
      failure,
      () => undefined,
    );
    end();
    const refused = Promise.reject<string>(new Error("There is no such topic."));
    showAnswer(
      () => refused,
      failure,
      () => undefined,
    );
    await Promise.resolve();
    expect(failure.value).toBe("There is no such topic.");
  });
});

/** A request that is refused once it is ended. */
const refusedAtEnd = (ending: AbortSignal, why: string): Promise<string> =>
  new Promise((_, refuse) => ending.addEventListener("abort", () => refuse(new Error(why))));
