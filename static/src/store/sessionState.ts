/** What the stream brings, and where a person looks: the part of the store that changes nothing on the server. */

import { batch, computed, type ReadonlySignal, signal } from "@preact/signals";
import { type Beam, beamAhead, beamToward, mirroredScan } from "../grid/beams";
import { around, type Bounds } from "../grid/bounds";
import { type Cell, cellAt, compose, contains, extent } from "../grid/lattice";
import type { MapPicture } from "../render/map/mapPicture";
import { fitted, type Size, type View } from "../render/view";
import type { Work } from "../ui/Working";
import type { BinaryFrame } from "../wire/decodeFrame";
import { KINDS } from "../wire/kinds";
import type {
  CellMessage,
  Command,
  Compared,
  ComparisonMessage,
  Contribution,
  Forgetting,
  Frame,
  FrameMessage,
  Hello,
  Point,
  Pose,
  ServerMessage,
  Trajectory,
  Values,
  WhyMessage,
  WorldMessage,
} from "../wire/protocol";
import type { DisplayedMap, OnCellChange } from "./displayedMap";
import { Editing } from "./editing";
import { Layers, MAP, SECOND_MAP } from "./layers";
import { Optimistic } from "./optimistic";
import { Outbox } from "./outbox";
import type { Stepping } from "./stepping";
import type { Receiver } from "./stream";

interface Notice {
  readonly kind: "note" | "error";
  readonly code: string;
  readonly message: string;
}

/** The cell of a map that holds a place; null outside the grid. */
export function cellIn(map: MapPicture | null, point: Point): Cell | null {
  if (!map) return null;
  const cell = cellAt(map.geometry, point[0], point[1]);
  return contains(map.geometry, cell) ? cell : null;
}

/** What a page knows of the session that it watches, and where it looks. */
export class SessionState implements Receiver {
  readonly hello = signal<Hello | null>(null);
  readonly frame = signal<Frame | null>(null);
  readonly world = signal<WorldMessage | null>(null);
  readonly trajectory = signal<Trajectory | null>(null);
  readonly mapping: Optimistic;
  readonly sensor: Optimistic;
  protected readonly robot: Optimistic;
  readonly #hasRobot = signal(false);

  /** What of the frame changes seldom: whoever shows only that is not rendered anew 30 times a second. */
  readonly isReady = computed(() => this.frame.value !== null);
  readonly playing = computed(() => this.frame.value?.playing ?? true);
  readonly speed = computed(() => this.frame.value?.speed ?? 1);
  readonly auto = computed(() => this.frame.value?.auto ?? true);
  /** Whether the robot goes where a person sends or drives it. */
  readonly isDriven = computed(() => KINDS[this.hello.value?.kind ?? ""]?.isDriven ?? false);

  /** The map on show. */
  readonly map: ReadonlySignal<MapPicture | null>;
  /** Grows whenever cells of the map on show change. */
  readonly mapVersion: ReadonlySignal<number>;
  /** The newest thing that a person should know. */
  readonly notice = signal<Notice | null>(null);

  /** What the server computes that takes longer than a moment; null while nothing does. */
  readonly working = signal<Work | null>(null);

  /** What both pictures show; null until their size and the world are known. */
  readonly view = signal<View | null>(null);
  /** Whether the view was moved by hand: it then no longer follows the map's growth. */
  readonly viewHeld = signal(false);
  /** The sizes of all pictures that show the view: what shows everything has to fit into the smallest of them. */
  readonly pictures = new Map<object, Size>();
  /** Where the pointer is in the world, in whichever picture. */
  readonly pointer = signal<Point | null>(null);
  /** A place that is looked at although the pointer is elsewhere: chosen by click or by the keyboard's cursor. */
  readonly pinned = signal<Point | null>(null);
  readonly inspected = signal<CellMessage | null>(null);
  /** The same of the cell of the second map. */
  readonly inspectedSecond = signal<CellMessage | null>(null);
  /** Where the robot was last sent by hand, and when (performance.now). */
  readonly teleported = signal<{ readonly at: number; readonly point: Point } | null>(null);

  /** Where the hand has the robot while it drags it. */
  readonly carried = signal<Point | null>(null);

  /** The place whose cell is explained; null while nobody asks why. */
  readonly asked = signal<Point | null>(null);
  /** The layer of the map in which it is explained. */
  readonly askedMap = signal<string>(MAP);
  /** The answer about that cell, the newest there is. */
  readonly why = signal<WhyMessage | null>(null);
  /** Number of the touch that is looked at; null for the newest. */
  readonly touched = signal<number | null>(null);

  /** The place that is looked at. */
  readonly probe = computed(() => this.pinned.value ?? this.pointer.value);
  /** The cell that is looked at; null outside the grid. */
  readonly cell: ReadonlySignal<Cell | null>;
  /** The cell that is explained; null outside the grid. */
  readonly askedCell: ReadonlySignal<Cell | null>;
  /** The map in which it is. */
  readonly askedPicture: ReadonlySignal<MapPicture | null>;
  /** The touch that is looked at; null where the answer does not tell of it. */
  readonly touch: ReadonlySignal<Contribution | null>;
  /** Where the map has the sensor at the newest scan: the stated mount with its correction among the parameters. */
  readonly beliefPose: ReadonlySignal<Pose | null>;
  /** The newest scan as the map takes it: mirrored where the mount is said to be upside down. */
  readonly beliefFrame: ReadonlySignal<Frame | null>;
  /** The beam towards the place that is looked at, straight ahead where there is none. */
  readonly inspectedBeam: ReadonlySignal<Beam | null>;
  /** All that is worth seeing, in world metres. */
  readonly bounds: ReadonlySignal<Bounds | null>;

  /** Which faults of the robot enter the map; null where there is no robot. */
  readonly faults: ReadonlySignal<Values | null>;
  /** What the second map has otherwise; null where there is none. */
  readonly compared = signal<Compared | null>(null);
  /** The second map, while the page watches it. */
  readonly second = signal<DisplayedMap | null>(null);
  /** How the two maps of a log differ. */
  readonly comparison = signal<ComparisonMessage | null>(null);
  /** The layer of the map that a person sees at a place, where the page shows two in one picture. */
  mapAt: ((point: Point) => string) | null = null;
  /** How far the maps have forgotten what was taken away; null while nobody watches that. */
  readonly forgetting = signal<Forgetting | null>(null);

  /** The scan that is stepped through cell by cell; null for none. */
  readonly stepping = signal<Stepping | null>(null);
  /** What is in the hand. */
  readonly editing = new Editing();

  /** What the session shows. */
  readonly layers: Layers;
  readonly #shown: DisplayedMap;
  readonly #transmit: (command: Command) => boolean;
  protected readonly outbox: Outbox;

  /** `transmit` sends a command and says whether there was a connection. */
  constructor(transmit: (command: Command) => boolean, outbox?: Outbox) {
    this.#transmit = transmit;
    this.outbox = outbox ?? new Outbox((command) => void transmit(command));
    this.layers = new Layers((command) => void transmit(command));
    this.#shown = this.layers.grid(MAP);
    this.map = this.#shown.map;
    this.mapVersion = this.#shown.version;
    this.mapping = new Optimistic();
    this.sensor = new Optimistic();
    this.robot = new Optimistic();
    this.faults = computed(() => (this.#hasRobot.value ? this.robot.values.value : null));
    // One by one: of a parameter that does not turn the sensor nothing follows here, and no picture is painted for it.
    const mount = (name: string) => computed(() => Number(this.mapping.values.value[name] ?? 0));
    const [mountX, mountY, mountYaw] = [mount("mount_x"), mount("mount_y"), mount("mount_yaw")];
    const isUpsideDown = computed(() => this.mapping.values.value.mount_upside_down === true);
    this.beliefPose = computed(() => {
      const frame = this.frame.value;
      if (!frame) return null;
      const stated = frame.believed_scan_pose ?? frame.scan_pose;
      return compose(stated, [mountX.value, mountY.value, mountYaw.value]);
    });
    this.beliefFrame = computed(() => {
      const frame = this.frame.value;
      if (!frame) return frame;
      const believed = frame.believed_pose ? { ...frame, pose: frame.believed_pose } : frame;
      return isUpsideDown.value ? mirroredScan(believed) : believed;
    });
    this.cell = computed(() => {
      const probe = this.probe.value;
      void this.map.value;
      return probe && this.cellOf(probe);
    });
    this.askedPicture = computed(() =>
      this.askedMap.value === SECOND_MAP ? (this.second.value?.map.value ?? null) : this.map.value,
    );
    this.askedCell = computed(() => {
      const asked = this.asked.value;
      return asked && cellIn(this.askedPicture.value, asked);
    });
    this.touch = computed(() => {
      const why = this.why.value;
      const first = why?.contributions[0];
      if (!why || !first) return null;
      const wanted = Math.min(this.touched.value ?? why.total, why.total);
      return why.contributions[wanted - first.n] ?? null;
    });
    this.inspectedBeam = computed(() => {
      const frame = this.beliefFrame.value;
      const pose = this.beliefPose.value;
      if (!frame || !pose || frame.ranges.length === 0) return null;
      const probe = this.probe.value;
      return (probe && beamToward(frame, pose, probe)) ?? beamAhead(frame);
    });
    this.bounds = computed(() => {
      const world = this.world.value;
      const map = this.map.value;
      if (world || !map) return world?.bounds ?? null;
      const own = extent(map.geometry);
      const second = this.second.value?.map.value;
      return second ? around(own, extent(second.geometry)) : own;
    });
  }

  /** The cell of the map on show that holds a place; null outside the grid. */
  cellOf(point: Point): Cell | null {
    return cellIn(this.map.peek(), point);
  }

  /** Show everything, in every picture, unless a person has chosen a part. */
  fit(): void {
    const bounds = this.bounds.peek();
    if (!bounds || this.viewHeld.peek()) return;
    const views = [...this.pictures.values()].map((size) => fitted(bounds, size));
    const widest = views.reduce<View | null>((best, view) => (best && best.scale >= view.scale ? best : view), null);
    if (widest) this.view.value = widest;
  }

  /** Show a part of the world that a person chose. */
  look(view: View): void {
    batch(() => {
      this.viewHeld.value = true;
      this.view.value = view;
    });
  }

  togglePlaying(): void {
    this.send({ type: this.frame.peek()?.playing ? "pause" : "play" });
  }

  /** Send a command at once, after those that wait for the next animation frame: they were given before it. */
  send(command: Command): void {
    this.outbox.flush();
    this.#transmit(command);
  }

  /** Send a command of which only the newest counts, with the next animation frame. */
  sendSoon(command: Command): void {
    this.outbox.put(command);
  }

  inspect({ row, col }: Cell, layer: string = MAP): void {
    const map = this.layers.grid(layer).map.peek();
    if (map) this.sendSoon({ type: "inspect", row, col, epoch: map.geometry.epoch, layer });
  }

  /** Ask why the cell at a place is what it is, in the map that is seen there; null for no more questions. */
  ask(place: Point | null, layer: string = (place && this.mapAt?.(place)) ?? MAP): void {
    batch(() => {
      const before = this.askedCell.peek();
      const map = this.askedMap.peek();
      this.asked.value = place;
      this.askedMap.value = layer;
      const now = this.askedCell.peek();
      if (map === layer && now && before && now.row === before.row && now.col === before.col) return;
      this.why.value = null;
      this.touched.value = null;
    });
  }

  /** Called for changed cells of the displayed map; see {@link DisplayedMap.onCellChange}. */
  set onCellChange(listener: OnCellChange | null) {
    this.#shown.onCellChange = listener;
  }

  // -- what the stream brings ------------------------------------------------------------------------------------

  receive(message: ServerMessage): void {
    batch(() => this.#receive(message));
  }

  #receive(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        this.#greet(message);
        return;
      case "layers":
        this.layers.setLayers(message.layers);
        return;
      case "geometry":
        this.layers.begin(message);
        return;
      case "frame":
        this.#look(message);
        return;
      case "world":
        if ((this.world.peek() ?? message).name !== message.name) this.viewHeld.value = false;
        this.world.value = message;
        this.editing.sketch.value = null;
        return;
      case "trajectory":
        this.trajectory.value = message;
        return;
      case "parameters":
        if (this.mapping.hear(message.values)) this.#shown.remake();
        if (message.sensor) this.sensor.hear(message.sensor);
        this.robot.hear(message.faults ?? {});
        this.#hasRobot.value = message.faults !== undefined;
        this.compared.value = message.compare ?? null;
        return;
      case "forgetting":
        this.forgetting.value = message.cells > 0 ? message : null;
        return;
      case "cell":
        if (message.layer === SECOND_MAP) this.inspectedSecond.value = message;
        else this.inspected.value = message;
        return;
      case "why": {
        const cell = this.askedCell.peek();
        const isAsked = message.layer === this.askedMap.peek();
        if (isAsked && cell?.row === message.row && cell.col === message.col) this.why.value = message;
        return;
      }
      case "comparison":
        this.comparison.value = message;
        return;
      case "working": {
        const { elapsed_s, fraction } = message;
        this.working.value = elapsed_s === null ? null : { elapsed_s, fraction };
        break;
      }
      case "notice":
        this.notice.value = { kind: "note", code: message.code, message: message.message };
        return;
      case "error":
        // A question about a map that was replaced meanwhile: no fault of the person's, and asked again of the new one.
        if (message.code === "command.epoch") return;
        for (const values of [this.mapping, this.sensor, this.robot]) values.refuse();
        this.notice.value = { kind: "error", code: message.code, message: message.message };
        return;
      case "pong":
        return;
    }
  }

  #look(message: FrameMessage): void {
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

  #greet(hello: Hello): void {
    const before = this.hello.peek();
    if (before && before.epoch_id !== hello.epoch_id) this.forget();
    this.hello.value = hello;
    this.mapping.greet(hello.parameters.values);
    if (hello.sensor) this.sensor.greet(hello.sensor.values);
    // What the hand set while the server was away still stands.
    for (const [type, set] of [["parameters", this.mapping] as const, ["sensor", this.sensor] as const]) {
      for (const [name, value] of Object.entries(set.pending())) this.outbox.putValue(type, name, value);
    }
    const faults = this.robot.pending();
    if (Object.keys(faults).length > 0) this.send({ type: "faults", values: faults });
  }

  /** What was set in a session that has ended, and never confirmed there, stands in the one that is made again. */
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
