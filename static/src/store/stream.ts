/**
 * The socket: it connects, decodes frames and passes them to the receiver, acknowledges each after the next animation
 * frame, and reconnects. While the page is hidden there is no socket, so that neither side works in vain.
 */

import { batch, signal } from "@preact/signals";
import { countSayers } from "../ui/browser/awaited";
import { type BinaryFrame, decodeFrame } from "../wire/decodeFrame";
import { decodeText, OutdatedPageError } from "../wire/decodeText";
import {
  CLOSE_SENTENCES,
  type Command,
  encodeCommand,
  MAYBE_OVER,
  ProtocolError,
  type ServerMessage,
  SUBPROTOCOL,
} from "../wire/protocol";
import { openSocket } from "./openSocket";

/** "gone" and "outdated" are final: the session has ended, or the page is older than the server. */
export type Status = "connecting" | "live" | "reconnecting" | "away" | "gone" | "outdated";

export interface Receiver {
  receive(message: ServerMessage): void;
  take(frame: BinaryFrame): void;
  /** The first commands of a new connection: the tiles to resume from, and the subscriptions. */
  opening(): readonly Command[];
  /** Discard what was received; the next connection starts from the beginning. */
  forget(): void;
}

export interface Socket {
  binaryType: string;
  onopen: (() => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  onclose: ((event: { code: number }) => void) | null;
  onerror: (() => void) | null;
  readonly readyState: number;
  send(data: string): void;
  close(): void;
}

/** The functions of a browser that the stream needs. */
export interface Environment {
  open(url: string, protocol: string): Socket;
  /** Run a task after `ms`; the result cancels it. */
  later(task: () => void, ms: number): () => void;
  /** Run a task every `ms`; the result ends it. */
  every(task: () => void, ms: number): () => void;
  /** Run a task at the next animation frame. */
  painted(task: () => void): void;
  hidden(): boolean;
  /** Call `changed` when the visibility changes or the network returns; the result stops it. */
  watch(changed: () => void): () => void;
}

const OPEN = 1;
const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 8000;
/** Failed attempts after which the page asks whether the session still exists. */
const DOUBTFUL = 2;
/** Interval of checking the connection. After an interval without any message the server is asked for a `pong`. */
const LISTEN_MS = 1000;
const STALLED = "The server does not answer. What is shown stays; the page continues as soon as it answers.";
/** Connections with an unreadable frame, after which the page is considered outdated. */
const MAX_UNREADABLE = 3;
const OUTDATED = "This page is older than the server. Reload the page.";

export const browser: Environment = {
  open: (url, protocol) => openSocket(url, protocol) as Socket,
  later: (task, ms) => {
    const timer = setTimeout(task, ms);
    return () => clearTimeout(timer);
  },
  every: (task, ms) => {
    const timer = setInterval(task, ms);
    return () => clearInterval(timer);
  },
  painted: (task) => void requestAnimationFrame(task),
  hidden: () => document.hidden,
  watch: (changed) => {
    document.addEventListener("visibilitychange", changed);
    addEventListener("online", changed);
    return () => {
      document.removeEventListener("visibilitychange", changed);
      removeEventListener("online", changed);
    };
  },
};

export class Stream {
  readonly status = signal<Status>("connecting");
  /** An error of the connection, for the user; null for none. */
  readonly trouble = signal<string | null>(null);
  /** Totals since the page opened. */
  readonly traffic = { bytes: 0, frames: 0, tiles: 0, connections: 0 };
  readonly #url: string;
  readonly #receiver: Receiver;
  readonly #environment: Environment;
  readonly #isGone: (code?: number) => Promise<boolean>;
  #socket: Socket | null = null;
  #failures = 0;
  #unreadable = 0;
  #stopped = false;
  /** Intervals without any message from the server; the first one ends with a ping. */
  #silent = 0;
  #cancelWait: (() => void) | null = null;
  #unwatch: (() => void) | null = null;
  #stopListening: (() => void) | null = null;

  /**
   * `isGone` returns whether the session has ended, from the code with which the server closed the socket or by asking
   * the server; `status` is then "gone" and the stream stops.
   */
  constructor(
    url: string,
    receiver: Receiver,
    isGone: (code?: number) => Promise<boolean>,
    environment: Environment = browser,
  ) {
    this.#url = url;
    this.#receiver = receiver;
    this.#isGone = isGone;
    this.#environment = environment;
  }

  start(): void {
    countSayers(1); // what shows the stream also shows its trouble
    this.#unwatch = this.#environment.watch(() => this.#visibilityChanged());
    this.#stopListening = this.#environment.every(() => this.#listen(), LISTEN_MS);
    this.#visibilityChanged();
  }

  stop(): void {
    this.#stopped = true;
    if (this.#unwatch) countSayers(-1);
    this.#unwatch?.();
    this.#unwatch = null;
    this.#stopListening?.();
    this.#disconnect();
  }

  /** Send a command; returns false without a connection. */
  send(command: Command): boolean {
    if (this.#socket?.readyState !== OPEN) return false;
    this.#socket.send(encodeCommand(command));
    return true;
  }

  #visibilityChanged(): void {
    if (this.#stopped || this.#isFinal()) return;
    if (this.#environment.hidden()) {
      this.#disconnect();
      this.status.value = "away";
    } else if (!this.#socket) {
      this.#failures = 0;
      this.#connect();
    }
  }

  /**
   * If a server keeps the connection, or does not accept it, and sends nothing, it has stalled. The page reports this
   * one interval after a ping.
   */
  #listen(): void {
    if (!this.#socket) return;
    this.#silent++;
    if (this.#silent === 2) this.send({ type: "ping", id: 0 });
    else if (this.#silent > 2) this.trouble.value ??= STALLED;
  }

  #heard(): void {
    this.#silent = 0;
    if (this.trouble.peek() === STALLED) this.trouble.value = null;
  }

  #disconnect(): void {
    this.#silent = 0;
    this.#cancelWait?.();
    this.#cancelWait = null;
    const socket = this.#socket;
    this.#socket = null;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = socket.onerror = null;
    socket.close();
  }

  #connect(): void {
    this.#disconnect();
    this.status.value = this.traffic.connections === 0 && this.#failures === 0 ? "connecting" : "reconnecting";
    const socket = this.#environment.open(this.#url, SUBPROTOCOL);
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.traffic.connections++;
      for (const command of this.#receiver.opening()) this.send(command);
    };
    socket.onmessage = ({ data }) => {
      this.#heard();
      try {
        this.#take(socket, data);
      } catch (error) {
        if (!(error instanceof ProtocolError)) throw error;
        this.#unreadable++;
        if (error instanceof OutdatedPageError || this.#unreadable >= MAX_UNREADABLE) {
          this.#end("outdated", OUTDATED);
          return;
        }
        // After an unreadable frame the state is unknown, so start from the beginning.
        this.#receiver.forget();
        this.#lost("The server sent something that this page cannot read.");
      }
    };
    socket.onclose = ({ code }) => {
      this.#lost(CLOSE_SENTENCES[code], MAYBE_OVER.includes(code) ? code : undefined);
    };
  }

  #take(socket: Socket, data: unknown): void {
    if (typeof data === "string") {
      this.traffic.bytes += data.length;
      const message = decodeText(data);
      if (message.type === "hello") {
        this.#failures = 0;
        this.status.value = "live";
        this.trouble.value = null;
      }
      this.#receiver.receive(message);
      return;
    }
    if (!(data instanceof ArrayBuffer)) throw new ProtocolError("frame.type", "A frame is text or an ArrayBuffer.");
    const frame = decodeFrame(data);
    this.traffic.bytes += data.byteLength;
    this.traffic.frames++;
    if (frame.kind === "tiles" || frame.kind === "changes") this.traffic.tiles += frame.tiles.length;
    this.#receiver.take(frame);
    this.#environment.painted(() => {
      if (this.#socket === socket) this.send({ type: "ack", seq: frame.seq });
    });
  }

  #isFinal(): boolean {
    const status = this.status.peek();
    return status === "gone" || status === "outdated";
  }

  #end(status: "gone" | "outdated", sentence: string): void {
    batch(() => {
      this.status.value = status;
      this.trouble.value = sentence;
    });
    this.stop();
  }

  /** With a code of `MAYBE_OVER` the page first asks whether the session still exists, and waits only if it does. */
  #lost(why = "The server does not answer.", code?: number): void {
    this.#disconnect();
    if (this.#stopped || this.#environment.hidden()) return;
    batch(() => {
      this.status.value = "reconnecting";
      // The first error is kept until the server answers again.
      this.trouble.value ??= `${why} The page tries again by itself.`;
    });
    if (code !== undefined) void this.#unlessGone(() => this.#wait(), code);
    else this.#wait();
  }

  #wait(): void {
    const wait = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** this.#failures);
    this.#failures++;
    this.#cancelWait = this.#environment.later(() => {
      this.#cancelWait = null;
      if (this.#failures >= DOUBTFUL) void this.#unlessGone(() => this.#connect());
      else this.#connect();
    }, wait);
  }

  /** Continue if the session still exists, and the page has not connected or been hidden while the server was asked. */
  async #unlessGone(goOn: () => void, code?: number): Promise<void> {
    if (await this.#isGone(code)) this.#end("gone", "This session has ended.");
    else if (!this.#stopped && !this.#socket && !this.#environment.hidden()) goOn();
  }
}
