/** Faults: the parameters that each of them sets, and its effects. Switching a fault off restores the parameters. */

import type { ActiveFaults } from "../../store/sessionSignals";
import type { Parameter, Value, Values } from "../../wire/protocol";

export interface Fault {
  readonly name: string;
  readonly label: string;
  /** What to look for. */
  readonly look: string;
  /** Parameters that the fault sets, by name. */
  readonly sets: Values;
  /** Faults of the robot itself. */
  readonly robot?: Values;
  /** Parameters of the correct map that differ from those before the fault. */
  readonly right?: Values;
}

export const FAULTS: readonly Fault[] = [
  {
    name: "rotated",
    label: "Laser mounted at an angle",
    look: "Each scan is rotated about the robot: as it drives, walls ahead shift sideways, and one wall is drawn in several places.",
    sets: { mount_yaw: 0.15 },
  },
  {
    name: "mirrored",
    label: "Laser upside down",
    look: "Left and right are exchanged: walls straight ahead are correct, but rooms appear on the wrong side of the corridor.",
    sets: { mount_upside_down: true },
  },
  {
    name: "drift",
    label: "Odometry drift",
    look: "The map is made with the poses from the odometry: a wall that is seen again later appears twice.",
    sets: {},
    robot: { drift: true },
  },
  {
    name: "no_return",
    label: "No return counted as a hit",
    look: "Where a beam has no return, the map gets a wall at the max range: arcs around the robot’s positions.",
    sets: { no_return: "hit", range_max: 4 },
  },
  {
    name: "specular",
    label: "Polished walls",
    look: "A beam that meets a long wall more than 30° off its normal is reflected away and has no return (a sonar hears the rest of its cone). Counted as free, it erases the wall.",
    sets: { no_return: "free" },
    robot: { specular: true },
  },
  {
    name: "counting",
    label: "Each beam counts",
    look: "Near the robot many beams of one scan cross the same cell, and each counts as independent evidence: point at cells along the path and read how certain they are.",
    sets: { update: "per_beam", clamp: false },
    right: { update: "per_scan", clamp: false },
  },
  {
    name: "no_clamp",
    label: "No clamp",
    look: "Log-odds grow without limit: the longer an object was seen, the longer it stays in the map after it was removed.",
    sets: { clamp: false },
  },
];

const named = (name: string): Fault | undefined => FAULTS.find((fault) => fault.name === name);

/** The faults that can be produced with the parameters of a table. */
export function availableFaults(table: readonly Parameter[]): readonly Fault[] {
  return FAULTS.filter((fault) =>
    Object.entries(fault.sets).every(([name, value]) => {
      const row = table.find((row) => row.name === name);
      return row !== undefined && (row.kind !== "choice" || row.choices.includes(String(value)));
    }),
  );
}

/**
 * Whether a fault is still active; a slider may have ended it. If `robot` is null, the robot's faults count as active.
 */
export function isOn(wrong: ActiveFaults, fault: Fault, values: Values, robot: Values | null): boolean {
  return (
    wrong.on.includes(fault.name) &&
    Object.entries(fault.sets).every(([name, value]) => values[name] === value || isTaken(wrong, fault, name)) &&
    Object.entries(fault.robot ?? {}).every(([name, value]) => !robot || robot[name] === value)
  );
}

/** Whether a fault that was switched on later also sets the parameter. */
function isTaken(wrong: ActiveFaults, fault: Fault, name: string): boolean {
  return wrong.on.slice(wrong.on.indexOf(fault.name) + 1).some((other) => name in (named(other)?.sets ?? {}));
}

/** The faults that are still active. */
export function stillActive(wrong: ActiveFaults, values: Values, robot: Values | null): ActiveFaults {
  const on = wrong.on.filter((name) =>
    FAULTS.some((fault) => fault.name === name && isOn(wrong, fault, values, robot)),
  );
  return on.length === wrong.on.length ? wrong : { on, before: wrong.before };
}

interface FaultSwitch {
  readonly wrong: ActiveFaults;
  readonly values: Values;
  readonly robot: Values;
}

/** Switch a fault on or off: the faults that are then active, and the parameters to set. */
export function switchFault(wrong: ActiveFaults, fault: Fault, wanted: boolean, values: Values): FaultSwitch {
  const others = wrong.on.filter((name) => name !== fault.name);
  const on = wanted ? [...others, fault.name] : others;
  const taken = on.flatMap((name) => Object.keys(named(name)?.sets ?? {}));
  const before: Record<string, Value> = {};
  for (const name of taken) {
    const value = wrong.before[name] ?? values[name];
    if (value !== undefined) before[name] = value;
  }
  const set: Record<string, Value> = {};
  for (const name of Object.keys(fault.sets)) {
    const last = on.findLast((other) => name in (named(other)?.sets ?? {}));
    const value = last === undefined ? wrong.before[name] : named(last)?.sets[name];
    if (value !== undefined) set[name] = value;
  }
  const robot = Object.fromEntries(Object.keys(fault.robot ?? {}).map((name) => [name, wanted]));
  return { wrong: { on, before }, values: set, robot };
}

/** The parameters in which the correct map differs from the map with the active faults. */
export function correctValues(wrong: ActiveFaults): Values {
  const right: Record<string, Value> = {};
  for (const name of wrong.on) {
    const fault = named(name);
    for (const key of Object.keys(fault?.sets ?? {})) {
      const value = fault?.right?.[key] ?? wrong.before[key];
      if (value !== undefined) right[key] = value;
    }
  }
  return right;
}
