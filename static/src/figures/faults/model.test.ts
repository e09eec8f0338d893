import { expect, test } from "vitest";
import type { Parameter, Values } from "../../protocol";
import { FAULTS, type Fault, isOn, possible, rightValues, turned } from "./model";
import { NOTHING_WRONG } from "./wrong";

const fault = (name: string): Fault => FAULTS.find((one) => one.name === name) as Fault;
const START: Values = { mount_yaw: 0.02, clamp: true, update: "per_scan", no_return: "ignore", range_max: 10 };

test("a switch sets what is wrong and gives back what was there, not what the table says", () => {
  const on = turned(NOTHING_WRONG, fault("rotated"), true, START);
  expect(on.values).toEqual({ mount_yaw: 0.15 });
  expect(isOn(on.wrong, fault("rotated"), { ...START, ...on.values }, {})).toBe(true);
  const off = turned(on.wrong, fault("rotated"), false, { ...START, ...on.values });
  expect(off.values).toEqual({ mount_yaw: 0.02 });
  expect(off.wrong).toEqual(NOTHING_WRONG);
});

test("two faults of one parameter: the later has it, and the first gets it back", () => {
  const first = turned(NOTHING_WRONG, fault("no_return"), true, START);
  const values = { ...START, ...first.values };
  const second = turned(first.wrong, fault("specular"), true, values);
  expect(second.values).toEqual({ no_return: "free" });
  expect(second.robot).toEqual({ specular: true });
  const both = { ...values, ...second.values };
  expect(isOn(second.wrong, fault("no_return"), both, { specular: true })).toBe(true);
  expect(isOn(second.wrong, fault("specular"), both, { specular: true })).toBe(true);
  const back = turned(second.wrong, fault("specular"), false, both);
  expect(back.values).toEqual({ no_return: "hit" });
  expect(back.robot).toEqual({ specular: false });
  const none = turned(back.wrong, fault("no_return"), false, { ...both, ...back.values });
  expect(none.values).toEqual({ no_return: "ignore", range_max: 10 });
});

test("a slider that moves the parameter ends the fault", () => {
  const { wrong, values } = turned(NOTHING_WRONG, fault("no_clamp"), true, START);
  expect(isOn(wrong, fault("no_clamp"), { ...START, ...values }, {})).toBe(true);
  expect(isOn(wrong, fault("no_clamp"), { ...START, clamp: true }, {})).toBe(false);
  const drift = turned(NOTHING_WRONG, fault("drift"), true, START);
  expect(isOn(drift.wrong, fault("drift"), START, { drift: false })).toBe(false);
  expect(isOn(NOTHING_WRONG, fault("no_clamp"), { ...START, clamp: false }, {})).toBe(false);
});

test("the map made right has what was there, except where the fault is the habit", () => {
  let wrong = turned(NOTHING_WRONG, fault("rotated"), true, START).wrong;
  expect(rightValues(wrong)).toEqual({ mount_yaw: 0.02 });
  wrong = turned(wrong, fault("counting"), true, START).wrong;
  expect(rightValues(wrong)).toEqual({ mount_yaw: 0.02, update: "per_scan", clamp: false });
});

test("a fault that the mapper cannot make yet is not offered", () => {
  const row = (name: string, kind: "number" | "choice" | "flag", choices: readonly string[] = []): Parameter =>
    ({ name, kind, choices }) as unknown as Parameter;
  const table = [
    row("mount_yaw", "number"),
    row("mount_upside_down", "flag"),
    row("no_return", "choice", ["ignore", "free"]),
    row("range_max", "number"),
    row("update", "choice", ["per_beam", "per_scan"]),
    row("clamp", "flag"),
  ];
  expect(possible(table).map((one) => one.name)).not.toContain("no_return");
  expect(possible(table)).toHaveLength(FAULTS.length - 1);
  expect(
    possible(table.map((one) => (one.name === "no_return" ? { ...one, choices: ["ignore", "free", "hit"] } : one))),
  ).toHaveLength(FAULTS.length);
});

test("each sentence is one sentence or two, and says where to look", () => {
  for (const { look, label } of FAULTS) {
    expect(look).toMatch(/\.$/);
    expect(look.length).toBeLessThan(180);
    expect(label.length).toBeLessThan(30);
  }
});
