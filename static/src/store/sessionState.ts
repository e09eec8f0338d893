/** The state received from the stream, and the view: the part of the store that changes nothing on the server. */

import { batch } from "@preact/signals";
import { boxAround, type Cell } from "../grid/lattice";
import { fitted, type View } from "../render/view";
import type { BinaryFrame } from "../wire/decodeFrame";
import type { Command, Frame, FrameMessage, Hello, Point, ServerMessage } from "../wire/protocol";
import type { OnCellChange } from "./displayedMap";
import { MAP, SECOND_MAP } from "./layers";
import { SessionSignals } from "./sessionSignals";
import type { Receiver } from "./stream";

/** State of the session that a page displays, and of its view. */
export class SessionState extends SessionSignals implements Receiver {
  /** Show everything in every picture, unless the user has chosen a view. */
  fitView(): void {
    const bounds = this.bounds.peek();
    if (!bounds || this.viewHeld.peek()) return;
    const views = [...this.pictures.values()].map((size) => fitted(bounds, size));
    const widest = views.reduce<View | null>((best, view) => (best && best.scale >= view.scale ? best : view), null);
    if (widest) this.view.value = widest;
  }

  /** Fit the pictures to the cells observed so far, once the map is received completely: a grid is of whole tiles. */
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

  /** Show the map after so many scans, and stay there: a log that plays would go on from it. */
  goTo(index: number): void {
    this.send({ type: "pause" });
    this.send({ type: "seek", index });
  }

  /** Send a command at once, after the earlier commands that wait for the next animation frame. */
  send(command: Command): void {
    this.outbox.flush();
    this.transmit(command);
  }

  /** Join the waiting commands of a type, as {@link Outbox.join}. */
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
        // A request about a map that was replaced meanwhile: not an error of the user, and sent again for the new map.
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
