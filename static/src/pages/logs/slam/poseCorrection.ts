/** SLAM of a log on its page: the job on the server, the pose graph, and the selection in it. */

import { effect, type Signal, signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { edgeAt, loopAt } from "../../../tools/slam/poseGraph";
import { type LandscapePlace, pairAt } from "../../../tools/slam/scoreLandscape";
import type {
  ChangeOfGraph,
  EdgeAnswer,
  PoseGraphAnswer,
  ScanConstraints,
  ScoreLandscape,
  TriedLoopScans,
  TriedNear,
} from "../../../wire/http";
import type { Point } from "../../../wire/protocol";
import { JobParameters } from "../jobs/jobParameters";
import { LogJob } from "../jobs/LogJob";
import * as api from "./api";

/** The layer of the graph. */
const LAYER = "graph";
/** A pointer that rests on an edge for this time requests its scans. */
const REST_MS = 60;

export class PoseCorrection extends LogJob<api.SlamStatus> {
  /** The pose graph of the trajectory in use; null if it has none. */
  readonly graph = signal<PoseGraphAnswer | null>(null);
  readonly edge = signal<EdgeAnswer | null>(null);
  /** The scores around the selected loop; null until they are known. */
  readonly landscape = signal<ScoreLandscape | null>(null);
  /** The edge under the pointer. */
  readonly hovered = signal<EdgeAnswer | null>(null);
  readonly candidate = signal<TriedLoopScans | null>(null);
  /** The edges of the selected pose. */
  readonly constraints = signal<ScanConstraints | null>(null);
  /** The place of the question. */
  readonly place = signal<{ readonly at: Point; readonly found: TriedNear } | null>(null);
  /** The target of a click on the map while the graph is shown. */
  readonly takesTap = signal<((point: Point) => boolean) | null>(null);
  /** The trajectory of the map before SLAM. */
  readonly before: Signal<string | null> = signal(null);
  /** The parameters of the next job. */
  readonly parameters = new JobParameters(api.slamParameters);
  #restTimer = 0;
  #pointed: number | null = null;

  constructor(store: Store, session: string) {
    super(store, session, { state: api.slamState, cancel: api.cancelSlam }, (job) =>
      this.parameters.adopt(job.parameters),
    );
  }

  /** Correct the log's poses with SLAM; a running job is followed. */
  begin(): Promise<void> {
    const trajectory = this.store.trajectory.peek()?.name ?? null;
    if (this.graph.peek() === null && !this.isUnderWay.peek()) this.before.value = trajectory;
    this.#deselect();
    this.graph.value = null;
    return this.follow(() => api.correctPoses(this.session, this.parameters.changed()));
  }

  /** Show the graph of the trajectory in use, if it has one. */
  async load(): Promise<void> {
    try {
      this.graph.value = await api.poseGraph(this.session);
    } catch {
      this.graph.value = null;
    }
  }

  /** Select a loop: both of its scans are shown. */
  readonly select = (edge: number): Promise<void> =>
    this.request("Asking", async () => {
      const detail = await api.edgeOf(this.session, edge);
      this.#deselect();
      this.edge.value = detail;
      this.store.scanPair.value = detail;
      void this.#loadLandscape(edge);
    });

  /** Select the pose of a scan, from 0, and list its edges. Returns whether the poses have a graph. */
  async selectPose(scan: number): Promise<boolean> {
    const detail = await api.constraintsOf(this.session, scan);
    this.#deselect();
    this.constraints.value = detail;
    return detail !== null;
  }

  async #loadLandscape(edge: number): Promise<void> {
    try {
      const landscape = await api.landscapeOf(this.session, edge);
      if (this.edge.peek()?.edge === edge) this.landscape.value = landscape;
    } catch {
      // A scan without points has no score landscape.
    }
  }

  /** Show the later scan of the selected loop at a position of the landscape; null for that of the loop. */
  tryPlace(place: LandscapePlace | null): void {
    const edge = this.edge.peek();
    const landscape = this.landscape.peek();
    if (edge && landscape) this.store.scanPair.value = place ? pairAt(edge, landscape, place) : edge;
  }

  readonly selectCandidate = (candidate: number): Promise<void> =>
    this.request("Asking", async () => {
      const detail = await api.candidateOf(this.session, candidate);
      this.#deselect();
      this.candidate.value = detail;
      this.store.scanPair.value = detail;
    });

  /** Ask why no loop closed at a place. */
  readonly ask = (at: Point): Promise<void> =>
    this.request("Asking", async () => {
      const detail = await api.placeOf(this.session, ...at);
      this.#deselect();
      this.place.value = { at, found: detail };
    });

  #deselect(): void {
    this.edge.value = null;
    this.landscape.value = null;
    this.candidate.value = null;
    this.constraints.value = null;
    this.place.value = null;
    this.#endHover();
    this.store.scanPair.value = null;
  }

  #endHover(): void {
    clearTimeout(this.#restTimer);
    this.#pointed = null;
    if (this.hovered.peek() === null) return;
    this.hovered.value = null;
    this.store.scanPair.value = this.edge.peek() ?? this.candidate.peek();
  }

  /** Both scans of the edge under the pointer are shown while it rests there. */
  #hover(edge: number | null): void {
    if (edge === this.#pointed) return;
    this.#endHover();
    this.#pointed = edge;
    if (edge === null) return;
    this.#restTimer = window.setTimeout(async () => {
      try {
        const detail = await api.edgeOf(this.session, edge);
        if (this.#pointed !== edge) return;
        this.hovered.value = detail;
        this.store.scanPair.value = detail;
      } catch {
        // The graph was changed meanwhile.
      }
    }, REST_MS);
  }

  /** Edit the graph; the map follows. */
  readonly change = (change: ChangeOfGraph): Promise<void> =>
    this.request("Asking", async () => {
      const edge = this.edge.peek()?.edge;
      this.graph.value = await api.changeGraph(this.session, change);
      this.#deselect();
      const isStill = edge !== undefined && edge !== change.remove && change.remove === undefined && !change.reset;
      if (isStill) await this.select(edge);
    });

  readonly keep = (): Promise<void> =>
    this.request("Asking", async () => {
      await api.keepGraph(this.session);
    });

  /** Show the graph as a layer, and handle clicks on the map. The returned function ends both. */
  show(): () => void {
    const unsubscribe = this.store.layers.subscribe(LAYER);
    this.takesTap.value = (point) => {
      if (this.graph.peek() === null) return false;
      const edge = loopAt(this.store.layers.content(LAYER).peek(), point, this.store.view.peek()?.scale ?? 0);
      void (edge === null ? this.ask(point) : this.select(edge));
      return true;
    };
    const unwatch = effect(() => {
      const point = this.store.pointer.value;
      const isShown = this.graph.value !== null && !this.isBusy.value;
      this.#hover(
        point && isShown
          ? edgeAt(this.store.layers.content(LAYER).peek(), point, this.store.view.peek()?.scale ?? 0)
          : null,
      );
    });
    return () => {
      unwatch();
      unsubscribe();
      this.takesTap.value = null;
      this.#deselect();
    };
  }
}

/** The correction of a session's log. A guest only sees the graph. */
export function usePoseCorrection(store: Store, session: string, isGuest: boolean): PoseCorrection {
  const correction = useMemo(() => new PoseCorrection(store, session), [store, session]);
  const log = store.hello.value?.log?.id ?? null;
  useEffect(() => {
    if (!isGuest && log !== null) correction.start();
    return () => correction.stop();
  }, [correction, log, isGuest]);
  return correction;
}
