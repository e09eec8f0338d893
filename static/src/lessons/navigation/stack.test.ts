import { afterEach, describe, expect, it } from "vitest";
import { backToPath } from "../stage/path";
import { begin, driveAt, LENGTH, phaseOf, setGoal, step, walkAt } from "./stack";
import {
  crateAt,
  freePlan,
  looked,
  pathGoal,
  placeOfTable,
  plan,
  probeAt,
  remains,
  robotRadius,
  saved,
  sheets,
  since,
  switched,
  tablePlan,
} from "./state";
import { cellOf, centreOfCell } from "./world";

afterEach(backToPath);

describe("the layers", () => {
  it("have the wall, the crate, the trail and the zone each in its own", () => {
    const at = (id: string, point: readonly [number, number]) =>
      sheets.value.find((sheet) => sheet.id === id)?.own[cellOf(point)];
    const crate = [crateAt.value[0] - 0.25, crateAt.value[1]] as const;
    expect(at("static", [0.45, 2])).toBe(254);
    expect(at("static", crate)).toBe(0);
    expect(at("obstacle", crate)).toBe(254);
    expect(at("obstacle", [6.2, 1.3])).toBe(0);
    expect(at("dynamic", [4.98 + 0.2, 2.6])).toBe(254);
    expect(at("dynamic", [1.2 + 0.2, 2.6])).toBe(255);
    expect(at("keepout", [10.5, 7])).toBe(254);
    const cost = sheets.value.at(-1)?.master[cellOf(probeAt.value)] ?? 0;
    expect(cost).toBeGreaterThan(0);
    switched.value = { ...switched.value, inflation: false };
    expect(sheets.value.at(-1)?.master[cellOf(probeAt.value)]).toBe(0);
  });
});

describe("the path", () => {
  it("leads through the doors, and not through one that inflation shuts", () => {
    expect(plan.value.path?.length).toBeGreaterThan(60);
    robotRadius.value = 0.7;
    expect(plan.value.path).toBeNull();
    robotRadius.value = 0.2;
    pathGoal.value = [5.05, 5];
    expect(plan.value.path).toBeNull();
  });
});

describe("the table that was taken away", () => {
  const detour = () => tablePlan.value.length - freePlan.value.length;

  it("is driven round until its layer is cleared or has forgotten it, and permanently in the map", () => {
    expect(detour()).toBeGreaterThan(0.3);
    looked.value = [[4, 2.1, 0]];
    expect(remains.value.filter((cost) => cost === 254).length).toBeLessThan(8);
    placeOfTable.value = "static";
    expect(detour()).toBeGreaterThan(0.3);
    since.value = 60;
    expect(detour()).toBeGreaterThan(0.3);
    placeOfTable.value = "dynamic";
    expect(detour()).toBe(0);
    since.value = 12;
    looked.value = [];
    expect(detour()).toBeGreaterThan(0.3);
  });
});

describe("the whole stack", () => {
  it("finds the robot, and drives it round the crate to the goal", () => {
    const [, index] = phaseOf(begin("nav2") - 1);
    expect(walkAt(index).past.at(-1)?.near).toBeGreaterThan(0.9);
    const last = driveAt(LENGTH - 1 - begin("nav2"));
    expect(last.arrived).toBe(true);
    expect(last.walk.past.at(-1)?.near).toBeGreaterThan(0.9);
    const crate = [...driveAt(9).costs.keys()].filter((i) => {
      const [x, y] = centreOfCell(i);
      return driveAt(9).costs[i] === 254 && saved.value[i] !== 254 && Math.abs(x - 4.6) < 0.5 && Math.abs(y - 2) < 0.5;
    });
    expect(crate.length).toBeGreaterThan(3);
  });

  it("takes another goal on the way", () => {
    step.value = begin("nav2") + 5;
    setGoal([10.6, 6.4]);
    const end = driveAt(5).plan.path?.at(-1) ?? [0, 0];
    expect(Math.hypot(end[0] - 10.6, end[1] - 6.4)).toBeLessThan(0.1);
  });
});
