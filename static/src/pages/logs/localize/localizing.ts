/** Localization of a log in a map on the page: the map, the job on the server, and where the robot starts. */

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { GIVEN_MAP, PARTICLES } from "../../../tools/localization/model";
import { filterTable } from "../../../tools/localization/table";
import type { Point, Pose } from "../../../wire/protocol";
import { JobParameters } from "../jobParameters";
import * as api from "./api";

const EVERY_MS = 400;
/** When the map is asked for again after the server has not answered. */
const MAP_AGAIN_MS = 2000;

export type MapSource = "own" | "other" | "files";

const isUnderWay = (job: api.LocalizationStatus | null): boolean => job?.state === "queued" || job?.state === "running";

export class Localizing {
  /** The newest job; null until the server has told. */
  readonly job = signal<api.LocalizationStatus | null>(null);
  readonly map = signal<api.MapAnswer | null>(null);
  readonly history = signal<api.FilterHistory | null>(null);
  readonly failure = signal<string | null>(null);
  /** What the server is doing for a request; null for nothing. */
  readonly doing = signal<string | null>(null);
  readonly source = signal<MapSource>("own");
  /** Whether the robot starts at `pose`, else anywhere. */
  readonly hasPose = signal(false);
  readonly pose = signal<Pose | null>(null);
  /** Whether the next click on the map says where the robot looks. */
  readonly turns = signal(false);
  readonly isUnderWay: ReadonlySignal<boolean> = computed(() => isUnderWay(this.job.value));
  readonly badge: ReadonlySignal<string | null> = computed(() =>
    this.isUnderWay.value ? `${Math.floor(100 * (this.job.value?.fraction ?? 0))} %` : null,
  );
  readonly parameters = new JobParameters(filterTable);
  #timer = 0;
  #mapTimer = 0;
  #isShown = false;

  constructor(
    readonly store: Store,
    readonly session: string,
  ) {}

  async #ask(doing: string, what: () => Promise<void>): Promise<void> {
    this.doing.value = doing;
    this.failure.value = null;
    try {
      await what();
    } catch (error) {
      this.failure.value = (error as Error).message;
    } finally {
      this.doing.value = null;
    }
  }

  #chosen(map: api.MapAnswer | null): void {
    this.map.value = map;
    this.pose.value = null;
    this.turns.value = false;
    this.store.underlay.value = GIVEN_MAP;
    this.store.viewHeld.value = false;
  }

  readonly chooseLog = (log: string, topic: string | null, trajectory: string | null): Promise<void> =>
    this.#ask("Making the map", async () => {
      this.#chosen(await api.chooseLog(this.session, { log, topic, trajectory }));
    });

  readonly chooseFiles = (files: readonly File[]): Promise<void> =>
    this.#ask("Reading the map", async () => {
      this.#chosen(await api.chooseFiles(this.session, files));
    });

  begin(odometry: string | null): Promise<void> {
    this.turns.value = false;
    return this.#ask("Beginning", async () => {
      const initial_pose = this.hasPose.peek() ? this.pose.peek() : null;
      this.history.value = null;
      this.store.underlay.value = GIVEN_MAP;
      this.job.value = await api.localize(this.session, {
        initial_pose,
        odometry,
        parameters: this.parameters.changed(),
      });
      this.#follow();
    });
  }

  readonly cancel = (): Promise<void> =>
    this.#ask("Cancelling", async () => {
      this.job.value = await api.cancelLocalization(this.session);
    });

  /** Ask whether a job is running, or for the result of the last one. */
  async look(): Promise<void> {
    const known = this.job.peek();
    try {
      const job = await api.localizationState(this.session);
      if (this.job.peek() === known) {
        // Otherwise a job was begun or cancelled meanwhile, and this may be the state before.
        if (known === null) this.parameters.adopt(job.parameters.values ?? {});
        this.job.value = job;
      }
    } catch {
      // The server does not answer: another time.
    }
    this.#follow();
  }

  #follow(): void {
    clearTimeout(this.#timer);
    if (this.#timer !== -1 && this.isUnderWay.peek()) this.#timer = window.setTimeout(() => void this.look(), EVERY_MS);
  }

  start(): void {
    this.#timer = 0;
    void this.look();
  }

  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = -1;
  }

  /** Show the map that was chosen earlier. */
  async loadMap(): Promise<void> {
    clearTimeout(this.#mapTimer);
    if (this.map.peek() !== null) return;
    try {
      const map = await api.referenceMap(this.session);
      if (this.map.peek() === null) this.map.value = map; // one may have been chosen meanwhile
    } catch {
      // The server does not answer, for example because another one has just taken the session over.
      if (this.#isShown) this.#mapTimer = window.setTimeout(() => void this.loadMap(), MAP_AGAIN_MS);
    }
  }

  /** Show how certain the poses in use are, where they come from a localization. */
  async loadHistory(): Promise<void> {
    try {
      this.history.value = await api.filterHistory(this.session);
      if (this.history.peek()) this.store.underlay.value = GIVEN_MAP;
    } catch {
      this.history.value = null;
    }
  }

  /** A click on the map: first where the robot starts, then where it looks. */
  readonly takeTap = ([x, y]: Point): boolean => {
    if (!this.hasPose.peek() || this.isUnderWay.peek() || this.store.underlay.peek() !== GIVEN_MAP) return false;
    const pose = this.pose.peek();
    if (this.turns.peek() && pose) {
      this.pose.value = [pose[0], pose[1], Math.atan2(y - pose[1], x - pose[0])];
      this.turns.value = false;
    } else {
      this.pose.value = [x, y, pose?.[2] ?? 0];
      this.turns.value = true;
    }
    return true;
  };

  /** Show the layers while the group is open; the result ends that. */
  show(): () => void {
    this.#isShown = true;
    const ends = [this.store.layers.subscribe(GIVEN_MAP), this.store.layers.subscribe(PARTICLES)];
    return () => {
      this.#isShown = false;
      clearTimeout(this.#mapTimer);
      if (this.store.underlay.peek() === GIVEN_MAP) this.store.underlay.value = null;
      this.store.givenPose.value = null;
      for (const end of ends) end();
    };
  }
}

/** The localization of a session's log. A guest only sees its course. */
export function useLocalizing(store: Store, session: string, isGuest: boolean): Localizing {
  const localizing = useMemo(() => new Localizing(store, session), [store, session]);
  const log = store.hello.value?.log?.id ?? null;
  useEffect(() => {
    if (!isGuest && log !== null) localizing.start();
    return () => localizing.stop();
  }, [localizing, log, isGuest]);
  return localizing;
}
