import { expect, test } from "vitest";
import { NO_ACTIVE_FAULTS } from "../../store/sessionSignals";
import type { Parameter, Values } from "../../wire/protocol";
import { availableFaults, correctValues, FAULTS, type Fault, isOn, switchFault } from "./model";

const fault = (name: string): Fault => FAULTS.find((fault) => fault.name === name) as Fault;
const START: Values = { mount_yaw: 0.02, clamp: true, update: "per_scan", no_return: "ignore", range_max: 10 };

test("a switch sets the fault's parameters and restores the previous values, not the initial ones", () => {
  const on = switchFault(NO_ACTIVE_FAULTS, fault("rotated"), true, START);
  expect(on.values).toEqual({ mount_yaw: 0.15 });
  expect(isOn(on.wrong, fault("rotated"), { ...START, ...on.values }, {})).toBe(true);
  const off = switchFault(on.wrong, fault("rotated"), false, { ...START, ...on.values });
  expect(off.values).toEqual({ mount_yaw: 0.02 });
  expect(off.wrong).toEqual(NO_ACTIVE_FAULTS);
});

test("two faults of one parameter: the later has it, and the first gets it back", () => {
  const first = switchFault(NO_ACTIVE_FAULTS, fault("no_return"), true, START);
  const values = { ...START, ...first.values };
  const second = switchFault(first.wrong, fault("specular"), true, values);
  expect(second.values).toEqual({ no_return: "free" });
  expect(second.robot).toEqual({ specular: true });
  const both = { ...values, ...second.values };
  expect(isOn(second.wrong, fault("no_return"), both, { specular: true })).toBe(true);
  expect(isOn(second.wrong, fault("specular"), both, { specular: true })).toBe(true);
  const back = switchFault(second.wrong, fault("specular"), false, both);
  expect(back.values).toEqual({ no_return: "hit" });
  expect(back.robot).toEqual({ specular: false });
  const none = switchFault(back.wrong, fault("no_return"), false, { ...both, ...back.values });
  expect(none.values).toEqual({ no_return: "ignore", range_max: 10 });
});

test("a slider that moves the parameter ends the fault", () => {
  const { wrong, values } = switchFault(NO_ACTIVE_FAULTS, fault("no_clamp"), true, START);
  expect(isOn(wrong, fault("no_clamp"), { ...START, ...values }, {})).toBe(true);
  expect(isOn(wrong, fault("no_clamp"), { ...START, clamp: true }, {})).toBe(false);
  const drift = switchFault(NO_ACTIVE_FAULTS, fault("drift"), true, START);
  expect(isOn(drift.wrong, fault("drift"), START, { drift: false })).toBe(false);
  expect(isOn(NO_ACTIVE_FAULTS, fault("no_clamp"), { ...START, clamp: false }, {})).toBe(false);
});

test("the map made right has what was there, except where the fault is the habit", () => {
  let wrong = switchFault(NO_ACTIVE_FAULTS, fault("rotated"), true, START).wrong;
  expect(correctValues(wrong)).toEqual({ mount_yaw: 0.02 });
  wrong = switchFault(wrong, fault("counting"), true, START).wrong;
  expect(correctValues(wrong)).toEqual({ mount_yaw: 0.02, update: "per_scan", clamp: false });
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
  expect(availableFaults(table).map((availableFault) => availableFault.name)).not.toContain("no_return");
  expect(availableFaults(table)).toHaveLength(FAULTS.length - 1);
  expect(
    availableFaults(
      table.map((row) => (row.name === "no_return" ? { ...row, choices: ["ignore", "free", "hit"] } : row)),
    ),
  ).toHaveLength(FAULTS.length);
});

test("each text is one or two sentences", () => {
  for (const { look, label } of FAULTS) {
    expect(look).toMatch(/\.$/);
    expect(look.length).toBeLessThan(180);
    expect(label.length).toBeLessThan(30);
  }
});
