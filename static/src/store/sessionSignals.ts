/** The signals of a session and of its view, and values computed from them. */

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import { type Beam, beamAhead, beamToward, mirroredScan } from "../grid/beams";
import { around, type Bounds, type Cell, cellAt, compose, contains, extent } from "../grid/lattice";
import type { MappingConfig } from "../grid/occupancyGrid";
import type { MapPicture } from "../render/map/mapPicture";
import type { Size, View } from "../render/view";
import type { Work } from "../ui/Working";
import type { EdgeAnswer } from "../wire/http";
import { KINDS } from "../wire/kinds";
import type {
  CellMessage,
  Command,
  Compared,
  Contribution,
  Frame,
  Geometry,
  Hello,
  Point,
  Pose,
  ServerMessage,
  Trajectory,
  Value,
  Values,
  WhyMessage,
  WorldMessage,
} from "../wire/protocol";
import type { DisplayedMap } from "./displayedMap";
import { Editing } from "./editing";
import { Layers, MAP, SECOND_MAP } from "./layers";
import { Optimistic } from "./optimistic";

/** The active faults, in the order in which they were switched on, and the earlier parameters. */
export interface ActiveFaults {
  readonly on: readonly string[];
  readonly before: Values;
}

export const NO_ACTIVE_FAULTS: ActiveFaults = { on: [], before: {} };

export interface Step {
  readonly beam: number;
  /** Index of the cell on the beam, from 0, and the number of the beam's cells. */
  readonly place: number;
  readonly of: number;
  readonly cell: Cell;
  readonly evidence: number;
  readonly isHit: boolean;
  /** Bresenham's error term in this cell; null in the last. */
  readonly nabla: number | null;
}

/** A scan that is stepped through; the map does not contain it yet. */
export interface Stepping {
  readonly frame: Frame;
  /** The sensor's pose at the scan in the map frame. */
  readonly pose: Pose;
  readonly geometry: Geometry;
  readonly config: MappingConfig;
  readonly steps: readonly Step[];
  /** Number of steps done. */
  readonly done: number;
  /** Number of scans in the map; when it changes, the stepping ends. */
  readonly index: number;
}

/**
 * Run a task after the next frame is painted, so that the user's own change is displayed first, and a server on the
 * same machine takes no time from that frame.
 */
const afterFrame = (task: () => void): void => void requestAnimationFrame(() => void setTimeout(task));

const valuesOf = (command: Command): Values => ("values" in command && command.values) || {};

function joined(before: Command, command: Command): Command {
  const values = { ...valuesOf(before), ...valuesOf(command) };
  return { ...before, ...command, ...(Object.keys(values).length > 0 && { values }) } as Command;
}

/** Waiting commands. Of each kind only the newest is sent, once per animation frame. */
export class Outbox {
  readonly #waiting = new Map<string, Command>();
  readonly #joined = new Set<string>();
  readonly #send: (command: Command) => void;
  readonly #schedule: (task: () => void) => void;

  constructor(send: (command: Command) => void, schedule: (task: () => void) => void = afterFrame) {
    this.#send = send;
    this.#schedule = schedule;
  }

  /** Merge the commands of a type field by field, such as those of the costmap: the newest value of each is sent. */
  join(type: string): void {
    this.#joined.add(type);
  }

  put(command: Command): void {
    const isFirst = this.#waiting.size === 0;
    // Of requests about two layers, the newest for each is sent.
    const about = "layer" in command ? ` ${command.layer}` : "";
    const key = command.type + about;
    const before = this.#waiting.get(key);
    this.#waiting.set(key, before && this.#joined.has(command.type) ? joined(before, command) : command);
    if (isFirst) this.#schedule(() => this.flush());
  }

  /** Add one value to the waiting `parameters` or `sensor` command. */
  putValue(type: "parameters" | "sensor", name: string, value: Value): void {
    const waiting = this.#waiting.get(type);
    const before = waiting ? valuesOf(waiting) : {};
    this.put({ type, values: { ...before, [name]: value } });
  }

  flush(): void {
    const commands = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const command of commands) this.#send(command);
  }
}

class PartState<M extends ServerMessage = ServerMessage> {
  /** Null before the first message. */
  readonly message = signal<M | null>(null);
  readonly values = new Optimistic();
  /** Whether its layer is drawn over the belief. */
  readonly isOver = signal(false);
  /** Whether the user has ended it; it then does not begin automatically. */
  readonly isEnded = signal(false);

  take(message: M): void {
    this.message.value = message;
    if ("values" in message) this.values.update(message.values);
  }
}

interface Notice {
  readonly kind: "note" | "error";
  readonly code: string;
  readonly message: string;
}

/** Two scans in the map, m: each at its pose, and the second also as placed by a measurement between them. */
export type ScanPair = Pick<EdgeAnswer, "scans" | "poses" | "points">;

/** The cell of a map at a point; null outside the grid. */
export function cellIn(map: MapPicture | null, point: Point): Cell | null {
  if (!map) return null;
  const cell = cellAt(map.geometry, point[0], point[1]);
  return contains(map.geometry, cell) ? cell : null;
}

/** A name that no other page has. */
const newName = (): string =>
  Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");

/** The page's data about a session, and about its view. */
export class SessionSignals {
  /** The name by which the server identifies the page; its 3D views have it in their addresses. */
  readonly page = newName();
  readonly hello = signal<Hello | null>(null);
  readonly frame = signal<Frame | null>(null);
  readonly world = signal<WorldMessage | null>(null);
  readonly trajectory = signal<Trajectory | null>(null);
  readonly mapping: Optimistic;
  readonly sensor: Optimistic;
  protected readonly robot: Optimistic;
  protected readonly hasRobot = signal(false);

  /** Parts of the frame that change rarely. Components that show only these are not rendered 30 times a second. */
  readonly isReady = computed(() => this.frame.value !== null);
  readonly playing = computed(() => this.frame.value?.playing ?? true);
  readonly speed = computed(() => this.frame.value?.speed ?? 1);
  readonly auto = computed(() => this.frame.value?.auto ?? true);
  /** Whether the user can drive the robot. */
  readonly isDriven = computed(() => KINDS[this.hello.value?.kind ?? ""]?.isDriven ?? false);

  /** The displayed map. */
  readonly map: ReadonlySignal<MapPicture | null>;
  /** Incremented whenever cells of the displayed map change. */
  readonly mapVersion: ReadonlySignal<number>;
  /** The newest message to the user. */
  readonly notice = signal<Notice | null>(null);

  /** Progress of a long computation of the server; null for none. */
  readonly working = signal<(Work & { readonly what: string }) | null>(null);

  /** The view of all pictures; null until their size and the world are known. */
  readonly view = signal<View | null>(null);
  /** Whether the user moved the view, which then no longer follows the growth of the map. */
  readonly viewHeld = signal(false);
  /** The box around the observed cells, to which the view is fitted instead of the grid; null for the grid. */
  readonly observed = signal<Bounds | null>(null);
  /** The sizes of all pictures of the view. A view of everything must fit into the smallest. */
  readonly pictures = new Map<object, Size>();
  /** The pointer's position in the world, in any picture. */
  readonly pointer = signal<Point | null>(null);
  /** An inspected point that does not follow the pointer: chosen by click or by the keyboard's cursor. */
  readonly pinned = signal<Point | null>(null);
  readonly inspected = signal<CellMessage | null>(null);
  /** The values of the same cell in the second map. */
  readonly inspectedSecond = signal<CellMessage | null>(null);
  /** Where the user last moved the robot, and when (performance.now). */
  readonly teleported = signal<{ readonly at: number; readonly point: Point } | null>(null);

  /** The point to which the robot is being dragged; null while it is not dragged. */
  readonly draggedTo = signal<Point | null>(null);

  /** The point whose cell is explained; null while no explanation is shown. */
  readonly explainedPoint = signal<Point | null>(null);
  /** The layer of the explained cell. */
  readonly explainedLayer = signal<string>(MAP);
  /** The newest explanation of that cell. */
  readonly why = signal<WhyMessage | null>(null);
  /** Number of the selected update of the explained cell, from 1; null for the newest. */
  readonly selectedUpdate = signal<number | null>(null);

  /** The two scans of a loop that are shown in the map; null for none. */
  readonly scanPair = signal<ScanPair | null>(null);

  /** The inspected point. */
  readonly probe = computed(() => this.pinned.value ?? this.pointer.value);
  /** The inspected cell; null outside the grid. */
  readonly cell: ReadonlySignal<Cell | null>;
  /** The explained cell; null outside the grid. */
  readonly explainedCell: ReadonlySignal<Cell | null>;
  /** The map of the explained cell. */
  readonly explainedMap: ReadonlySignal<MapPicture | null>;
  /** The contribution of the selected update; null if the answer does not contain it. */
  readonly selectedContribution: ReadonlySignal<Contribution | null>;
  /** The sensor's pose at the newest scan in the map: the stated mount with its correction from the parameters. */
  readonly beliefPose: ReadonlySignal<Pose | null>;
  /** The newest scan as used in the map: mirrored if the mount is set to upside down. */
  readonly beliefFrame: ReadonlySignal<Frame | null>;
  /** The beam towards the inspected point; without one the beam straight ahead. */
  readonly inspectedBeam: ReadonlySignal<Beam | null>;
  /** Bounds of the world or of the maps, in metres. */
  readonly bounds: ReadonlySignal<Bounds | null>;

  /** The robot's faults; null if there is no robot. */
  readonly faults: ReadonlySignal<Values | null>;
  /** The differences of the second map; null if there is none. */
  readonly compared = signal<Compared | null>(null);
  /** The second map while the page is subscribed to it. */
  readonly second = signal<DisplayedMap | null>(null);
  /** The layer displayed at a point, if the page shows two maps in one picture. */
  mapAt: ((point: Point) => string) | null = null;
  /** The grid layer that the belief shows instead of the map; null for the map. */
  readonly underlay = signal<string | null>(null);
  /** The visitor's estimate of the robot's pose in a map in which it will be localized. */
  readonly givenPose = signal<Pose | null>(null);

  /** The scan that is stepped through cell by cell; null for none. */
  readonly stepping = signal<Stepping | null>(null);
  /** The selected editing tool. */
  readonly editing = new Editing();

  /** The data about the parts of the session, by the type of their messages. */
  protected readonly parts = new Map<string, PartState>();
  /** The layers of the session. */
  readonly layers: Layers;
  protected readonly shown: DisplayedMap;
  protected readonly transmit: (command: Command) => boolean;
  protected readonly outbox: Outbox;

  /** `transmit` sends a command and returns whether there was a connection. */
  constructor(transmit: (command: Command) => boolean, outbox?: Outbox) {
    this.transmit = transmit;
    this.outbox = outbox ?? new Outbox((command) => void transmit(command));
    this.layers = new Layers((command) => void transmit(command));
    this.shown = this.layers.grid(MAP);
    this.map = this.shown.map;
    this.mapVersion = this.shown.version;
    this.mapping = new Optimistic();
    this.sensor = new Optimistic();
    this.robot = new Optimistic();
    this.faults = computed(() => (this.hasRobot.value ? this.robot.values.value : null));
    // A signal for each parameter of the mount, so that the pictures are not repainted for other parameters.
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
    this.explainedMap = computed(() =>
      this.explainedLayer.value === SECOND_MAP ? (this.second.value?.map.value ?? null) : this.map.value,
    );
    this.explainedCell = computed(() => {
      const point = this.explainedPoint.value;
      return point && cellIn(this.explainedMap.value, point);
    });
    this.selectedContribution = computed(() => {
      const why = this.why.value;
      const first = why?.contributions[0];
      if (!why || !first) return null;
      const update = Math.min(this.selectedUpdate.value ?? why.total, why.total);
      return why.contributions[update - first.n] ?? null;
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
      const under = this.underlay.value === null ? null : this.layers.grid(this.underlay.value).map.value;
      if (under) return extent(under.geometry);
      const own = this.observed.value ?? extent(map.geometry);
      const second = this.second.value?.map.value;
      return second ? around(own, extent(second.geometry)) : own;
    });
  }

  /** The state of the part whose messages have a type. Its commands with values have the same type. */
  part<T extends ServerMessage["type"]>(type: T): PartState<Extract<ServerMessage, { type: T }>> {
    const part = this.parts.get(type) ?? new PartState();
    this.parts.set(type, part);
    this.outbox.join(type);
    return part as unknown as PartState<Extract<ServerMessage, { type: T }>>;
  }

  /** The cell of the displayed map at a point; null outside the grid. */
  cellOf(point: Point): Cell | null {
    return cellIn(this.map.peek(), point);
  }
}
