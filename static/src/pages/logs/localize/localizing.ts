/** Localization of a log in a map: the map, the job on the server, and the start of the robot. */

import { signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import { GIVEN_MAP, PARTICLES } from "../../../tools/localization/model";
import { ask } from "../../../wire/ask";
import type { FilterHistory, LocalizationStatus, MapAnswer, MapOfLog, NewLocalization } from "../../../wire/http";
import type { Point, Pose } from "../../../wire/protocol";
import { JobParameters } from "../jobs/jobParameters";
import { LogJob } from "../jobs/LogJob";
import { tarred } from "../library/groupFiles";

const localizationState = (session: string): Promise<LocalizationStatus> =>
  ask("GET /api/sessions/{session_id}/localization", { session_id: session });

export const localize = (session: string, body: NewLocalization): Promise<LocalizationStatus> =>
  ask("POST /api/sessions/{session_id}/localization", { session_id: session }, { body });

const cancelLocalization = (session: string): Promise<LocalizationStatus> =>
  ask("DELETE /api/sessions/{session_id}/localization", { session_id: session });

/** The uncertainty of the poses in use over the log; null if they are not from a localization. */
const filterHistory = async (session: string): Promise<FilterHistory | null> =>
  (await ask("GET /api/sessions/{session_id}/localization/course", { session_id: session })).course;

/** The selected map; null for none. */
const referenceMap = async (session: string): Promise<MapAnswer | null> =>
  (await ask("GET /api/sessions/{session_id}/localization/map", { session_id: session })).map;

/** Select the map of a log along one of its trajectories. */
export const chooseLog = async (session: string, body: MapOfLog): Promise<MapAnswer | null> =>
  (await ask("PUT /api/sessions/{session_id}/localization/map", { session_id: session }, { body })).map;

/** Select map files: a yaml with its image, or a map of CMU's course. */
export async function chooseFiles(session: string, files: readonly File[]): Promise<MapAnswer | null> {
  const isYaml = ({ name }: File): boolean => /\.ya?ml$/i.test(name);
  const named = files.find(isYaml) ?? files[0];
  if (!named) return null;
  const body = files.length === 1 && !isYaml(named) ? named : tarred(files, named.name);
  const what = "PUT /api/sessions/{session_id}/localization/map-files";
  return (await ask(what, { session_id: session }, { query: { name: named.name }, body })).map;
}

/** Delay before the map is requested again if the server did not answer. */
const MAP_AGAIN_MS = 2000;

export type MapSource = "own" | "other" | "files";

export class Localizing extends LogJob<LocalizationStatus> {
  readonly map = signal<MapAnswer | null>(null);
  readonly history = signal<FilterHistory | null>(null);
  readonly source = signal<MapSource>("own");
  /** Whether the robot starts at `pose` instead of anywhere. */
  readonly hasPose = signal(false);
  readonly pose = signal<Pose | null>(null);
  /** Whether the next click on the map sets the robot's heading. */
  readonly turns = signal(false);
  readonly parameters = new JobParameters(async () => (await ask("GET /api/localization/parameters", {})).table);
  #mapTimer = 0;
  #isShown = false;

  constructor(store: Store, session: string) {
    super(store, session, { state: localizationState, cancel: cancelLocalization }, (job) =>
      this.parameters.adopt(job.parameters.values ?? {}),
    );
  }

  #chosen(map: MapAnswer | null): void {
    this.map.value = map;
    this.pose.value = null;
    this.turns.value = false;
    this.store.underlay.value = GIVEN_MAP;
    this.store.viewHeld.value = false;
  }

  readonly chooseLog = (log: string, topic: string | null, trajectory: string | null): Promise<void> =>
    this.request("Making the map", async () => {
      this.#chosen(await chooseLog(this.session, { log, topic, trajectory }));
    });

  readonly chooseFiles = (files: readonly File[]): Promise<void> =>
    this.request("Reading the map", async () => {
      this.#chosen(await chooseFiles(this.session, files));
    });

  begin(odometry: string | null): Promise<void> {
    this.turns.value = false;
    const initial_pose = this.hasPose.peek() ? this.pose.peek() : null;
    this.history.value = null;
    this.store.underlay.value = GIVEN_MAP;
    const request = { initial_pose, odometry, parameters: this.parameters.changed() };
    return this.follow(() => localize(this.session, request));
  }

  /** Show the map that was selected earlier. */
  async loadMap(): Promise<void> {
    clearTimeout(this.#mapTimer);
    if (this.map.peek() !== null) return;
    try {
      const map = await referenceMap(this.session);
      if (this.map.peek() === null) this.map.value = map; // one may have been selected meanwhile
    } catch {
      // The server does not answer, for example because another one has just taken over the session.
      if (this.#isShown) this.#mapTimer = window.setTimeout(() => void this.loadMap(), MAP_AGAIN_MS);
    }
  }

  /** Show the uncertainty of the poses in use if they are from a localization. */
  async loadHistory(): Promise<void> {
    try {
      this.history.value = await filterHistory(this.session);
      if (this.history.peek()) this.store.underlay.value = GIVEN_MAP;
    } catch {
      this.history.value = null;
    }
  }

  /** A click on the map: first the start of the robot, then its heading. */
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

  /** Show the layers while the group is open; the returned function ends that. */
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

/** The localization of a session's log. A guest only sees its progress. */
export function useLocalizing(store: Store, session: string, isGuest: boolean): Localizing {
  const localizing = useMemo(() => new Localizing(store, session), [store, session]);
  const log = store.hello.value?.log?.id ?? null;
  useEffect(() => {
    if (!isGuest && log !== null) localizing.start();
    return () => localizing.stop();
  }, [localizing, log, isGuest]);
  return localizing;
}
