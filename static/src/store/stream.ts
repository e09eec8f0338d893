/**
 * The socket: connects, reads frames and hands them on, acknowledges once a picture could be painted, and comes back
 * by itself. While the page is hidden there is no socket, so neither side works for nobody.
 */

import { batch, signal } from "@preact/signals";
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

/** Of these, "gone" and "outdated" are final: the session has ended, or the page is older than the server. */
export type Status = "connecting" | "live" | "reconnecting" | "away" | "gone" | "outdated";

export interface Receiver {
  receive(message: ServerMessage): void;
  take(frame: BinaryFrame): void;
  /** The commands with which a new connection begins: what is still there, and what is wanted. */
  opening(): readonly Command[];
  /** Everything received is void: the next connection starts anew. */
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

/** What the stream needs of a browser. */
export interface Surroundings {
  open(url: string, protocol: string): Socket;
  /** Run a task after `ms`; the result cancels it. */
  later(task: () => void, ms: number): () => void;
  /** Run a task when what has changed is painted. */
  painted(task: () => void): void;
  hidden(): boolean;
  /** Hear of changes of visibility and of a network that came back; the result stops it. */
  watch(changed: () => void): () => void;
}

const OPEN = 1;
const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 8000;
/** Attempts after which it is worth asking whether the session still exists. */
const DOUBTFUL = 2;
/** Connections that brought a frame which cannot be read, after which the page is taken to be outdated. */
const MAX_UNREADABLE = 3;
const OUTDATED = "This page is older than the server. Reload the page.";

export const browser: Surroundings = {
  open: (url, protocol) => new WebSocket(url, protocol) as Socket,
  later: (task, ms) => {
    const timer = setTimeout(task, ms);
    return () => clearTimeout(timer);
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
  /** What is wrong with the connection, for the person; null while nothing is. */
  readonly trouble = signal<string | null>(null);
  /** Totals since the page opened. */
  readonly traffic = { bytes: 0, frames: 0, tiles: 0, connections: 0 };
  readonly #url: string;
  readonly #receiver: Receiver;
  readonly #around: Surroundings;
  readonly #isGone: () => Promise<boolean>;
  #socket: Socket | null = null;
  #failures = 0;
  #unreadable = 0;
  #stopped = false;
  #cancelWait: (() => void) | null = null;
  #unwatch: (() => void) | null = null;

  /** `isGone` asks whether the session has ended for good; `status` is then "gone" and nothing is tried any more. */
  constructor(url: string, receiver: Receiver, isGone: () => Promise<boolean>, around: Surroundings = browser) {
    this.#url = url;
    this.#receiver = receiver;
    this.#isGone = isGone;
    this.#around = around;
  }

  start(): void {
    this.#unwatch = this.#around.watch(() => this.#visibilityChanged());
    this.#visibilityChanged();
  }

  stop(): void {
    this.#stopped = true;
    this.#unwatch?.();
    this.#disconnect();
  }

  /** Send a command; says whether there is a connection to send it on. */
  send(command: Command): boolean {
    if (this.#socket?.readyState !== OPEN) return false;
    this.#socket.send(encodeCommand(command));
    return true;
  }

  #visibilityChanged(): void {
    if (this.#stopped || this.#isFinal()) return;
    if (this.#around.hidden()) {
      this.#disconnect();
      this.status.value = "away";
    } else if (!this.#socket) {
      this.#failures = 0;
      this.#connect();
    }
  }

  #disconnect(): void {
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
    const socket = this.#around.open(this.#url, SUBPROTOCOL);
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.traffic.connections++;
      for (const command of this.#receiver.opening()) this.send(command);
    };
    socket.onmessage = ({ data }) => {
      try {
        this.#take(socket, data);
      } catch (error) {
        if (!(error instanceof ProtocolError)) throw error;
        this.#unreadable++;
        if (error instanceof OutdatedPageError || this.#unreadable >= MAX_UNREADABLE) {
          this.#end("outdated", OUTDATED);
          return;
        }
        // What follows a frame that cannot be read cannot be trusted: start anew.
        this.#receiver.forget();
        this.#lost("The server sent something that this page cannot read.");
      }
    };
    socket.onclose = ({ code }) => {
      if (MAYBE_OVER.includes(code)) this.#failures = Math.max(this.#failures, DOUBTFUL - 1);
      this.#lost(CLOSE_SENTENCES[code]);
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
    if (frame.kind === "tiles") this.traffic.tiles += frame.tiles.length;
    this.#receiver.take(frame);
    this.#around.painted(() => {
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

  #lost(why = "The server does not answer."): void {
    this.#disconnect();
    if (this.#stopped || this.#around.hidden()) return;
    batch(() => {
      this.status.value = "reconnecting";
      // The first cause stays until the server answers again.
      this.trouble.value ??= `${why} The page tries again by itself.`;
    });
    const wait = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** this.#failures);
    this.#failures++;
    this.#cancelWait = this.#around.later(() => void this.#retry(), wait);
  }

  async #retry(): Promise<void> {
    this.#cancelWait = null;
    if (this.#failures >= DOUBTFUL && (await this.#isGone())) {
      this.#end("gone", "This session has ended.");
      return;
    }
    if (!this.#stopped && !this.#socket && !this.#around.hidden()) this.#connect();
  }
}
