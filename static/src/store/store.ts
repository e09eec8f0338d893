/** The store of a page that displays a session: every component reads and changes it, and none depends on another. */

import { batch, signal } from "@preact/signals";
import type { Command, Edits, Parameter, Point, ServerMessage, Value, Values } from "../wire/protocol";
import { type ActiveFaults, NO_ACTIVE_FAULTS } from "./activeFaults";
import { NO_EDITS } from "./editing";
import { History } from "./history";
import { SessionState } from "./sessionState";

const initialOf = (table: readonly Parameter[]): Values =>
  Object.fromEntries(table.map((row) => [row.name, row.initial]));

/** The parts that have parameters: their messages and their commands have one type, and both have values. */
type PartType = Extract<ServerMessage, { readonly values: Values }>["type"] &
  Extract<Command, { readonly values?: Values }>["type"];

/** The changes of the user, with undo and redo. */
export class Store extends SessionState {
  /** The user's changes, for undo and redo. */
  readonly history = new History((command) => this.#perform(command));
  /** The faults that the user has switched on, and the values before. */
  readonly activeFaults = signal<ActiveFaults>(NO_ACTIVE_FAULTS);

  readonly #states = new Map<unknown, unknown>();
  readonly #heard = new Map<string, (command: Command) => void>();

  /** The state that a tool keeps beside the messages: made when it is first asked for, and the same from then on. */
  of<S>(State: new (store: Store) => S): S {
    const state = (this.#states.get(State) as S | undefined) ?? new State(this);
    this.#states.set(State, state);
    return state;
  }

  /** Call `listener` with each change of a type of command, also one that is undone; it is sent soon. */
  hears(type: Command["type"], listener: (command: Command) => void): void {
    this.#heard.set(type, listener);
  }

  setParameter(name: string, value: Value): void {
    this.change(`parameters ${name}`, this.#back("parameters", { [name]: value }), [
      { type: "parameters", values: { [name]: value } },
    ]);
  }

  setSensor(name: string, value: Value): void {
    this.change(`sensor ${name}`, this.#back("sensor", { [name]: value }), [
      { type: "sensor", values: { [name]: value } },
    ]);
  }

  /** Set several parameters, and the robot's faults, at once. */
  setTogether(key: string, values: Values, faults: Values = {}): void {
    const before = this.faults.peek() ?? {};
    const old = Object.fromEntries(Object.keys(faults).map((name) => [name, before[name] ?? false]));
    const any = Object.keys(faults).length > 0;
    this.change(
      key,
      [...this.#back("parameters", values), ...(any ? [{ type: "faults", values: old } as const] : [])],
      [{ type: "parameters", values }, ...(any ? [{ type: "faults", values: faults } as const] : [])],
    );
  }

  /** Set parameters of a part; begins it if it is off. */
  setPart(type: PartType, values: Values): void {
    const now = this.part(type).values.values.peek();
    const old = Object.fromEntries(Object.keys(values).map((name) => [name, now[name] ?? false]));
    this.change(`${type} ${Object.keys(values).join(" ")}`, [{ type, values: old }], [{ type, values }]);
  }

  teleport(point: Point): void {
    this.teleported.value = { at: performance.now(), point };
    this.#sendTo(point, "teleport");
    this.outbox.flush(); // a click is not followed by others: send it at once
  }

  /** Drag the robot to a point; null when it is released. */
  dragRobot(point: Point | null): void {
    this.draggedTo.value = point;
    if (point) this.#sendTo(point, "drag");
  }

  #sendTo([x, y]: Point, key: string): void {
    const pose = this.frame.peek()?.pose;
    const back: Command[] = pose ? [{ type: "teleport", x: pose[0], y: pose[1], yaw: pose[2] }] : [];
    this.change(key, back, [{ type: "teleport", x, y }]);
  }

  chooseWorld(name: string): void {
    const before = this.world.peek();
    if (!before || before.name === name) return;
    this.change("world", [{ type: "world", name: before.name, ...before.edits }], [{ type: "world", name }]);
  }

  /** Set the edits of the world; with `watch` the server counts how long the maps keep what is erased. */
  edit(edits: Edits, watch = false): void {
    const before = this.world.peek()?.edits ?? NO_EDITS;
    this.change(
      `edit ${this.history.version.peek()}`,
      [{ type: "edit", ...before }],
      [{ type: "edit", ...edits, ...(watch ? { watch } : {}) }],
    );
  }

  /** Restore all initial values, except the robot's pose and the map. */
  reset(): void {
    const hello = this.hello.peek();
    const world = this.world.peek();
    if (!hello) return;
    const values = initialOf(hello.parameters.table);
    const undo = [...this.#back("parameters", values)];
    const redo: Command[] = [{ type: "parameters", values }];
    if (hello.sensor) {
      const sensor = initialOf(hello.sensor.table);
      undo.push(...this.#back("sensor", sensor));
      redo.push({ type: "sensor", values: sensor });
    }
    const costmap = this.part("costmap");
    if (hello.tables.costmap && costmap.message.peek()?.is_on) {
      undo.push({ type: "costmap", values: costmap.values.values.peek() });
      redo.push({ type: "costmap", values: initialOf(hello.tables.costmap) });
    }
    const faults = this.faults.peek();
    if (faults) {
      undo.push({ type: "faults", values: faults });
      redo.push({ type: "faults", values: Object.fromEntries(Object.keys(faults).map((name) => [name, false])) });
    }
    if (world && world.edits.added.length + world.edits.erased.length > 0) {
      undo.push({ type: "edit", ...world.edits });
      redo.push({ type: "edit", ...NO_EDITS });
    }
    this.change("reset", undo, redo);
  }

  #back(type: "parameters" | "sensor", values: Values): Command[] {
    const now = (type === "parameters" ? this.mapping : this.sensor).values.peek();
    const old: Record<string, Value> = {};
    for (const name of Object.keys(values)) {
      const value = now[name];
      if (value !== undefined) old[name] = value;
    }
    return [{ type, values: old }];
  }

  /** Carry out a change of the user, which undo takes back. */
  change(key: string, undo: readonly Command[], redo: readonly Command[]): void {
    batch(() => {
      for (const command of redo) this.#perform(command);
      this.history.add(key, undo, redo);
    });
  }

  /** Carry out a command: values are displayed at once, and of frequent commands only the newest is sent. */
  #perform(command: Command): void {
    if (command.type === "parameters" || command.type === "sensor") {
      const target = command.type === "parameters" ? this.mapping : this.sensor;
      for (const [name, value] of Object.entries(command.values)) {
        target.set(name, value);
        this.outbox.putValue(command.type, name, value);
      }
    } else if (this.parts.has(command.type) || this.#heard.has(command.type)) {
      this.#heard.get(command.type)?.(command);
      const { values } = command as { readonly values?: Values };
      for (const [name, value] of Object.entries(values ?? {})) this.parts.get(command.type)?.values.set(name, value);
      this.sendSoon(command);
    } else if (command.type === "teleport") this.sendSoon(command);
    else {
      if (command.type === "faults")
        for (const [name, value] of Object.entries(command.values)) this.robot.set(name, value);
      this.send(command);
    }
  }
}
