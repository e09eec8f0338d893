/** A job on a session's log as followed by the page: SLAM, localization, merging. */

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { Store } from "../../../store/store";
import type { SlamStatus } from "../../../wire/http";

/** The state that all jobs report. */
export type JobStatus = Pick<SlamStatus, "state" | "fraction" | "ahead" | "elapsed_s">;

/** The requests of a kind of job. Each rejects with the server's sentence. */
interface JobRequests<S> {
  readonly state: (session: string) => Promise<S>;
  readonly cancel: (session: string) => Promise<S>;
}

const EVERY_MS = 400;

export class LogJob<S extends JobStatus> {
  /** The newest job; null until the server has reported it. */
  readonly job = signal<S | null>(null);
  readonly failure = signal<string | null>(null);
  /** The server's work for a request; null for none. */
  readonly doing = signal<string | null>(null);
  readonly isBusy: ReadonlySignal<boolean> = computed(() => this.doing.value !== null);
  readonly isUnderWay: ReadonlySignal<boolean> = computed(() => {
    const state = this.job.value?.state;
    return state === "queued" || state === "running";
  });
  readonly badge: ReadonlySignal<string | null> = computed(() =>
    this.isUnderWay.value ? `${Math.floor(100 * (this.job.value?.fraction ?? 0))} %` : null,
  );
  readonly #requests: JobRequests<S>;
  readonly #onFirst: (job: S) => void;
  #timer = 0;
  #isStopped = false;

  /** `onFirst` is called with the first reported state. */
  constructor(
    readonly store: Store,
    readonly session: string,
    requests: JobRequests<S>,
    onFirst: (job: S) => void = () => undefined,
  ) {
    this.#requests = requests;
    this.#onFirst = onFirst;
  }

  /** Send requests; a refusal is shown. */
  protected async request(doing: string, what: () => Promise<void>): Promise<void> {
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

  /** Start a job, or continue a running one, and follow it. */
  async follow(begun: () => Promise<S>): Promise<void> {
    await this.request("Beginning", async () => {
      this.job.value = await begun();
    });
    this.#lookAgain();
  }

  readonly cancel = (): Promise<void> =>
    this.request("Cancelling", async () => {
      this.job.value = await this.#requests.cancel(this.session);
    });

  /** Ask whether a job is running, or for the result of the last one. */
  async look(): Promise<void> {
    const known = this.job.peek();
    try {
      const job = await this.#requests.state(this.session);
      if (this.job.peek() === known) {
        // Otherwise a job was started or cancelled meanwhile, and this may be an older state.
        if (known === null) this.#onFirst(job);
        this.job.value = job;
      }
    } catch {
      // The server does not answer: try again later.
    }
    this.#lookAgain();
  }

  #lookAgain(): void {
    clearTimeout(this.#timer);
    if (!this.#isStopped && this.isUnderWay.peek()) this.#timer = window.setTimeout(() => void this.look(), EVERY_MS);
  }

  start(): void {
    this.#isStopped = false;
    void this.look();
  }

  stop(): void {
    this.#isStopped = true;
    clearTimeout(this.#timer);
  }
}
