/**
 * The connection of a page to a class: of the lecturer, who controls what is shown, or of a follower. A page follows a
 * class if its address is `/class/CODE/…`; the lecturer's browser stores the code of the open class.
 */

import { batch, computed, signal } from "@preact/signals";
import { addressOf, ask, RequestError, socketAddress } from "../wire/ask";
import { decodeClassText, OutdatedPageError } from "../wire/decodeText";
import type { OpenClassAnswer } from "../wire/http";
import {
  type ClassCommand,
  type ClassMessage,
  type ClassQuestion,
  type ClassState,
  type ClassViewMessage,
  type ClassWelcome,
  ProtocolError,
  SUBPROTOCOL,
  type WhyMessage,
} from "../wire/protocol";
import { openSocket } from "./openSocket";

const KEY = "gridbloom.class";
const FIRST_WAIT_MS = 200;
const LONGEST_WAIT_MS = 1500;
/** The close codes of the socket for a class that has ended, or that cannot be joined. */
const OVER: readonly number[] = [4404, 4410];

/** The code of the class that this page follows; null for none. */
export const followedCode: string | null = /^\/class\/([A-Z]{6})\//.exec(location.pathname)?.[1] ?? null;

export class Classroom {
  readonly code: string;
  readonly isFollowed: boolean;
  readonly state = signal<ClassState | null>(null);
  /** The question whose answers this page of the lecturer shows before the reveal; null for none. */
  readonly lookedAt = signal<number | null>(null);
  /**
   * The current question as shown on this page. The lecturer's screen is projected, so before the reveal it shows the
   * counts only if the lecturer requests it, and never the right answer.
   */
  readonly question = computed(() => {
    const asked = this.state.value?.question ?? null;
    if (!asked || asked.is_revealed) return asked;
    return { ...asked, counts: this.lookedAt.value === asked.id ? asked.counts : null, right: null };
  });
  readonly welcome = signal<ClassWelcome | null>(null);
  readonly shown = signal<ClassViewMessage | null>(null);
  readonly explained = signal<WhyMessage | null>(null);
  readonly isConnected = signal(false);
  /** Whether the class is over, or cannot be joined. */
  readonly isOver = signal(false);
  /** Whether the server is newer than this page, which must then be reloaded. */
  readonly isOutdated = signal(false);
  /** Why the last command was refused. */
  readonly refused = signal<string | null>(null);
  /** This follower's answer to the current question. */
  readonly answer = signal<{ readonly question: number; readonly value: number } | null>(null);
  /** Whether this follower requests the robot. */
  readonly asksForRobot = signal(false);
  /** The follower's own session for experiments; null while the lecturer is followed. */
  readonly own = signal<string | null>(null);
  /** Whether the page shows what the lecturer shows. */
  readonly isFollowing = computed(() => this.isFollowed && this.own.value === null && !this.isOver.value);
  /** Whether the lecturer has handed the robot to this follower. */
  readonly drives = computed(() => {
    const number = this.welcome.value?.number ?? 0;
    return number > 0 && this.state.value?.driver === number;
  });
  #socket: WebSocket | null = null;
  #failures = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** Whether no state was received since the last welcome. */
  #isJoining = false;
  /** Commands of the lecturer about what is currently shown. They are sent again after a reconnect. */
  readonly #last = new Map<ClassCommand["type"], ClassCommand>();

  constructor(code: string, isFollowed: boolean) {
    this.code = code;
    this.isFollowed = isFollowed;
    this.#connect();
    addEventListener("online", () => this.#again());
    document.addEventListener("visibilitychange", () => this.#again());
  }

  /**
   * Send a command. `show` and `explain` are sent once there is a connection again, other commands are dropped.
   * {@link give} and {@link raise} ensure that the service has the answer and the raised hand after a reconnect.
   */
  send(command: ClassCommand): void {
    if (command.type === "show" || command.type === "explain") this.#last.set(command.type, command);
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(command));
  }

  /** Answer a question, by default the current one. */
  give(value: number, question = this.state.peek()?.question?.id): void {
    if (question === undefined) return;
    this.answer.value = { question, value };
    this.send({ type: "answer", question, value });
  }

  /** Request the robot, or withdraw the request. */
  raise(value: boolean): void {
    this.asksForRobot.value = value;
    this.send({ type: "raise", value });
  }

  leave(): void {
    clearTimeout(this.#timer);
    this.isOver.value = true;
    this.#socket?.close();
  }

  #again(): void {
    if (document.hidden || this.isOver.peek() || this.isOutdated.peek() || this.#socket) return;
    clearTimeout(this.#timer);
    this.#connect();
  }

  #connect(): void {
    const path = addressOf("GET /api/classes/{code}", { code: this.code });
    const query = this.isFollowed ? "?follows=true" : ""; // the lecturer may follow the class in a second tab
    const socket = openSocket(socketAddress(`${path}/stream${query}`), SUBPROTOCOL);
    this.#socket = socket;
    socket.onopen = () => {
      for (const command of this.#last.values()) socket.send(JSON.stringify(command));
    };
    socket.onmessage = ({ data }) => {
      try {
        const message = decodeClassText(String(data));
        batch(() => this.#take(message));
      } catch (error) {
        if (!(error instanceof ProtocolError)) throw error;
        this.isOutdated.value ||= error instanceof OutdatedPageError;
        socket.close();
      }
    };
    socket.onclose = ({ code }) => {
      this.#socket = null;
      this.isConnected.value = false;
      if (OVER.includes(code)) this.isOver.value = true;
      if (this.isOver.peek() || this.isOutdated.peek()) return;
      this.#timer = setTimeout(() => this.#connect(), Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** this.#failures));
      this.#failures++;
    };
  }

  #take(message: ClassMessage): void {
    switch (message.type) {
      case "welcome":
        this.#failures = 0;
        this.#isJoining = true;
        this.isConnected.value = true;
        this.welcome.value = message;
        return;
      case "class": {
        const isJoining = this.#isJoining;
        this.#isJoining = false;
        this.#takeAnswer(message.question, isJoining ? this.welcome.peek()?.answer : undefined);
        this.state.value = message;
        if (message.has_ended) this.isOver.value = true;
        if (this.drives.peek()) this.asksForRobot.value = false;
        else if (isJoining && this.asksForRobot.peek()) this.send({ type: "raise", value: true });
        return;
      }
      case "view":
        this.shown.value = message;
        return;
      case "explained":
        this.explained.value = message.why;
        return;
      case "refused":
        this.refused.value = message.message;
        if (message.code === "class.closed") this.#takeCounted(message.answer ?? null);
    }
  }

  /** Show the counted answer, after one that came too late. */
  #takeCounted(counted: number | null): void {
    const question = this.answer.peek()?.question;
    if (question !== undefined) this.answer.value = counted === null ? null : { question, value: counted };
  }

  /**
   * Synchronize the answer of this page with the service. `known` is the service's answer after the page has joined,
   * null for none, and otherwise undefined. A socket may break unnoticed, so that a sent answer did not arrive; it is
   * sent again as long as answers are accepted.
   */
  #takeAnswer(asked: ClassQuestion | null, known: number | null | undefined): void {
    if (!asked) return;
    const ownAnswer = this.answer.peek();
    const isGiven = ownAnswer?.question === asked.id;
    if (isGiven && !asked.is_closed) {
      if (known !== undefined && known !== ownAnswer.value) this.give(ownAnswer.value, asked.id);
    } else if (!isGiven || known !== undefined)
      this.answer.value = known === undefined || known === null ? null : { question: asked.id, value: known };
  }
}

/** The browser's storage; null if it is forbidden. */
function storage(): Storage | null {
  try {
    return localStorage;
  } catch {
    return null;
  }
}

/** The class that this page belongs to; null for none. */
export const classroom = signal<Classroom | null>(null);

/** Whether this is a window that a lecturer shows: neither a picture of a slide nor the speaker's window. */
const isShown = parent === window && !new URLSearchParams(location.search).has("speaker");
const remembered = followedCode === null && isShown ? storage()?.getItem(KEY) : null;
if (followedCode !== null) classroom.value = new Classroom(followedCode, true);
else if (remembered) void reopen();

/** The service's information about the lecturer's own class, for the screen with its code. */
export const openClass = signal<OpenClassAnswer | null>(null);

function begin(opened: OpenClassAnswer): void {
  batch(() => {
    storage()?.setItem(KEY, opened.code);
    openClass.value = opened;
    if (classroom.peek()?.code !== opened.code) classroom.value = new Classroom(opened.code, false);
  });
}

/** Connect to the class that was open when the browser last showed a page. */
async function reopen(): Promise<void> {
  try {
    const answer = await ask("GET /api/classes", {});
    if (answer) begin(answer);
    else storage()?.removeItem(KEY);
  } catch (error) {
    if (error instanceof RequestError && error.status !== null) storage()?.removeItem(KEY);
  }
}

/** Open a class as its lecturer. Throws the service's refusal. */
export async function openOne(): Promise<void> {
  begin(await ask("POST /api/classes", {}));
}

/** End the lecturer's class. */
export async function endClass(): Promise<void> {
  const room = classroom.peek();
  if (!room || room.isFollowed) return;
  await ask("DELETE /api/classes/{code}", { code: room.code }).catch((error: RequestError) => {
    if (error.status !== 404) throw error;
  });
  storage()?.removeItem(KEY);
  room.leave();
  batch(() => {
    classroom.value = null;
    openClass.value = null;
  });
}

// --- questions of figures --------------------------------------------------------------------------------------------

/** The text of a question that the page itself shows, so that the class's line does not show it too. */
export const questionOnPage = signal<string | null>(null);

/** The text of a question that is the page's heading, so that the class's line does not repeat it. */
export const questionInHeading = signal<string | null>(null);

/** Declare that the page shows a question and, once visible, its answers, until the returned function is called. */
export function showsAnswers(text: string): () => void {
  questionOnPage.value = text;
  return () => {
    if (questionOnPage.peek() === text) questionOnPage.value = null;
  };
}

/** The question with this text as shown on this page, if it is the current one. */
export function askedAs(text: string): ClassQuestion | null {
  const asked = classroom.value?.question.value ?? null;
  return asked?.text === text ? asked : null;
}

/** The class whose lecturer uses this page; null for none. */
export const lecturersClass = computed(() => {
  const room = classroom.value;
  return room && !room.isFollowed ? room : null;
});
