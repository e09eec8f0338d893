/** The store of a page that displays a session. Every component reads and changes it, and none depends on another. */

import { batch, signal } from "@preact/signals";
import { boxAround, type Cell } from "../grid/lattice";
import { fitted, type View } from "../render/view";
import type { BinaryFrame } from "../wire/decodeFrame";
import type {
  Command,
  Edits,
  Frame,
  FrameMessage,
  Hello,
  Parameter,
  Point,
  ServerMessage,
  Value,
  Values,
} from "../wire/protocol";
import type { OnCellChange } from "./displayedMap";
import { NO_EDITS } from "./editing";
import { History } from "./history";
import { MAP, SECOND_MAP } from "./layers";
import { type ActiveFaults, NO_ACTIVE_FAULTS, SessionSignals } from "./sessionSignals";
import type { Receiver } from "./stream";

/** State of the session that a page displays, and of its view. */
class SessionState extends SessionSignals implements Receiver {
  /** Show everything in every picture, unless the user has chosen a view. */
  fitView(): void {
    const bounds = this.bounds.peek();
    if (!bounds || this.viewHeld.peek()) return;
    const views = [...this.pictures.values()].map((size) => fitted(bounds, size));
    const widest = views.reduce<View | null>((best, view) => (best && best.scale >= view.scale ? best : view), null);
    if (widest) this.view.value = widest;
  }

  /** Fit the pictures to the observed cells, once the map is received, because a grid consists of whole tiles. */
  fitObserved(): void {
    const map = this.map.peek();
    const box = this.shown.complete?.epoch === map?.geometry.epoch ? map?.cells.observedBox() : null;
    if (!map || !box) return;
    this.observed.value = boxAround(map.geometry, box.row0, box.col0, box.row1 + 1, box.col1 + 1);
  }

  /** Show a part of the world that the user chose. */
  setView(view: View): void {
    batch(() => {
      this.viewHeld.value = true;
      this.view.value = view;
    });
  }

  togglePlaying(): void {
    this.send({ type: this.frame.peek()?.playing ? "pause" : "play" });
  }

  /** Show the map after this number of scans, paused, because a playing log would continue. */
  goTo(index: number): void {
    this.send({ type: "pause" });
    this.send({ type: "seek", index });
  }

  /** Send a command at once, after the earlier commands that wait for the next animation frame. */
  send(command: Command): void {
    this.outbox.flush();
    this.transmit(command);
  }

  /** Merge the waiting commands of a type, see {@link Outbox.join}. */
  joins(type: Command["type"]): void {
    this.outbox.join(type);
  }

  /** Send a command with the next animation frame; a newer one of its kind replaces it. */
  sendSoon(command: Command): void {
    this.outbox.put(command);
  }

  inspect({ row, col }: Cell, layer: string = MAP): void {
    const map = this.layers.grid(layer).map.peek();
    if (map) this.sendSoon({ type: "inspect", row, col, epoch: map.geometry.epoch, layer });
  }

  /** Request the explanation of the cell at a point, by default in the map displayed there; null to close it. */
  explain(point: Point | null, layer: string = (point && this.mapAt?.(point)) ?? MAP): void {
    batch(() => {
      const before = this.explainedCell.peek();
      const map = this.explainedLayer.peek();
      this.explainedPoint.value = point;
      this.explainedLayer.value = layer;
      const now = this.explainedCell.peek();
      if (map === layer && now && before && now.row === before.row && now.col === before.col) return;
      this.why.value = null;
      this.selectedUpdate.value = null;
    });
  }

  /** Called for changed cells of the displayed map; see {@link DisplayedMap.onCellChange}. */
  set onCellChange(listener: OnCellChange | null) {
    this.shown.onCellChange = listener;
  }

  // -- received from the stream ------------------------------------------------------------------------------------

  receive(message: ServerMessage): void {
    batch(() => this.#receive(message));
  }

  #receive(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        this.#begin(message);
        return;
      case "layers":
        this.layers.setLayers(message.layers);
        return;
      case "geometry":
        this.layers.begin(message);
        return;
      case "frame":
        this.#setFrame(message);
        return;
      case "world":
        if ((this.world.peek() ?? message).name !== message.name) this.viewHeld.value = false;
        this.world.value = message;
        this.editing.sketch.value = null;
        return;
      case "trajectory":
        this.trajectory.value = message;
        return;
      case "trajectories": {
        const hello = this.hello.peek();
        const { trajectories, compared } = message;
        if (hello?.log) this.hello.value = { ...hello, log: { ...hello.log, trajectories, compared } };
        return;
      }
      case "parameters":
        if (this.mapping.update(message.values)) this.shown.remake();
        if (message.sensor) this.sensor.update(message.sensor);
        this.robot.update(message.faults ?? {});
        this.hasRobot.value = message.faults !== undefined;
        this.compared.value = message.compare ?? null;
        return;
      case "cell":
        if (message.layer === SECOND_MAP) this.inspectedSecond.value = message;
        else this.inspected.value = message;
        return;
      case "why": {
        const cell = this.explainedCell.peek();
        const isAsked = message.layer === this.explainedLayer.peek();
        if (isAsked && cell?.row === message.row && cell.col === message.col) this.why.value = message;
        return;
      }
      case "working": {
        const { elapsed_s, fraction, what } = message;
        this.working.value = elapsed_s === null ? null : { elapsed_s, fraction, what: what ?? "map" };
        break;
      }
      case "notice":
        this.notice.value = { kind: "note", code: message.code, message: message.message };
        return;
      case "error":
        // A request about a map that was replaced meanwhile. It is no user error, and is sent again for the new map.
        if (message.code === "command.epoch") return;
        for (const values of [this.mapping, this.sensor, this.robot]) values.refuse();
        for (const part of this.parts.values()) part.values.refuse();
        this.notice.value = { kind: "error", code: message.code, message: message.message };
        return;
      case "pong":
        return;
      default:
        this.part(message.type).take(message);
    }
  }

  #setFrame(message: FrameMessage): void {
    const before = this.frame.peek();
    const { ranges } = message;
    if (ranges !== undefined) this.frame.value = message as Frame;
    else if (before) {
      const { scan_pose, believed_scan_pose, angle_min, angle_increment, bearings, beam_width, range_max } = before;
      const seen = { scan_pose, ranges: before.ranges, angle_min, angle_increment, range_max };
      this.frame.value = {
        ...message,
        ...seen,
        ...(bearings && { bearings }),
        ...(beam_width && { beam_width }),
        ...(believed_scan_pose && { believed_scan_pose }),
      };
    }
  }

  #begin(hello: Hello): void {
    const before = this.hello.peek();
    if (before && before.epoch_id !== hello.epoch_id) this.forget();
    this.hello.value = hello;
    this.mapping.reconnected(hello.parameters.values);
    if (hello.sensor) this.sensor.reconnected(hello.sensor.values);
    // Send the values that were set while there was no connection.
    for (const [type, set] of [["parameters", this.mapping] as const, ["sensor", this.sensor] as const]) {
      for (const [name, value] of Object.entries(set.pending())) this.outbox.putValue(type, name, value);
    }
    const faults = this.robot.pending();
    if (Object.keys(faults).length > 0) this.send({ type: "faults", values: faults });
  }

  /** Take over the values that were set in an ended session and not confirmed there. */
  takeOver(from: SessionState): void {
    for (const kind of ["mapping", "sensor", "robot"] as const)
      for (const [name, value] of Object.entries(from[kind].pending())) this[kind].set(name, value);
  }

  take(frame: BinaryFrame): void {
    this.layers.take(frame);
  }

  opening(): readonly Command[] {
    return this.layers.opening(this.hello.peek()?.epoch_id);
  }

  forget(): void {
    this.layers.forget();
  }
}

const initialOf = (table: readonly Parameter[]): Values =>
  Object.fromEntries(table.map((row) => [row.name, row.initial]));

/** The parts with parameters: their messages and their commands have the same type, and both have values. */
type PartType = Extract<ServerMessage, { readonly values: Values }>["type"] &
  Extract<Command, { readonly values?: Values }>["type"];

/** The changes of the user, with undo and redo. */
export class Store extends SessionState {
  /** The user's changes, for undo and redo. */
  readonly history = new History((command) => this.#perform(command));
  /** The faults that the user has switched on, and the earlier values. */
  readonly activeFaults = signal<ActiveFaults>(NO_ACTIVE_FAULTS);

  readonly #states = new Map<unknown, unknown>();
  readonly #heard = new Map<string, (command: Command) => void>();

  /** The state that a tool keeps in addition to the messages. It is created on first use, and the same from then on. */
  of<S>(State: new (store: Store) => S): S {
    const state = (this.#states.get(State) as S | undefined) ?? new State(this);
    this.#states.set(State, state);
    return state;
  }

  /** Call `listener` with each change of a type of command, including undone ones. The command is sent soon. */
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
    this.outbox.flush(); // a click is not followed by others, so it is sent at once
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

  /** Carry out a change of the user, which undo reverts. */
  change(key: string, undo: readonly Command[], redo: readonly Command[]): void {
    batch(() => {
      for (const command of redo) this.#perform(command);
      this.history.add(key, undo, redo);
    });
  }

  /** Carry out a command. Values are displayed at once, and of frequent commands only the newest is sent. */
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
