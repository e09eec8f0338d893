// @vitest-environment happy-dom
import { describe, expect, test } from "vitest";
import type { Compared, Parameter } from "../../../wire/protocol";
import { changed, fragmentOf, type Linked, linkFromAddress, whole } from "./link";
import { differing, kindOf, names } from "./sides";

const row = (name: string, initial: number | boolean | string, unit = ""): Parameter =>
  ({ name, label: name.toUpperCase(), initial, unit }) as unknown as Parameter;

const TABLE = [row("hit", 0.85), row("range", 30, "m"), row("clamp", true), row("model", "fixed_increments")];
const KEPT: Compared = {
  values: { hit: 0.5, range: 30, clamp: true },
  with_faults: true,
  trajectory: "scan",
  log: null,
};

describe("the other side in words", () => {
  test("it keeps settings, has other poses, or is another log", () => {
    expect(kindOf(KEPT)).toBe("settings");
    expect(kindOf({ ...KEPT, values: {} })).toBe("poses");
    expect(kindOf({ ...KEPT, log: "x" })).toBe("log");
    expect(names({ ...KEPT, values: {}, trajectory: "wheel" }, "scan", "")).toEqual({
      a: "wheel odometry",
      b: "scan poses",
    });
    expect(names({ ...KEPT, log: "x", title: "aces" }, "scan", "intel")).toEqual({ a: "aces", b: "intel" });
  });

  test("only what differs is listed, as people read it", () => {
    const now = { hit: 0.85, range: 12.5, clamp: false, model: "smooth_ramp" };
    expect(differing(TABLE, KEPT, now)).toEqual([
      { name: "hit", label: "HIT", a: "0.5", b: "0.85" },
      { name: "range", label: "RANGE", a: "30 m", b: "12.5 m" },
      { name: "clamp", label: "CLAMP", a: "on", b: "off" },
    ]);
  });
});

describe("the link", () => {
  const linked: Linked = {
    look: "swipe",
    at: 31,
    mark: { a: "free", b: "occupied" },
    a: { values: { hit: 0.5 }, trajectory: "tf/map → x" },
    b: { values: {}, trajectory: "scan", index: 12 },
  };

  test("what was packed is unpacked", () => {
    expect(linkFromAddress(fragmentOf(linked))).toEqual(linked);
  });

  test("what was never packed is nothing", () => {
    for (const broken of ["", "#s=abc", "#compare=", "#compare=%", "#compare=3", '#compare={"look":"stare"}'])
      expect(linkFromAddress(broken)).toBeNull();
    expect(linkFromAddress('#compare={"look":"swipe","a":{},"b":{}}')).toBeNull();
  });

  test("values that are as at first are left out, and come back", () => {
    const values = { hit: 0.5, range: 30, clamp: true, model: "fixed_increments" };
    expect(changed(TABLE, values)).toEqual({ hit: 0.5 });
    expect(whole(TABLE, changed(TABLE, values))).toEqual(values);
  });
});
