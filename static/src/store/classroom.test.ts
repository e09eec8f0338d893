// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { ClassQuestion } from "../wire/protocol";
import { Classroom } from "./classroom";

/** A socket of a service that answers what the test tells it to. */
class FakeSocket extends EventTarget {
  static readonly OPEN = 1;
  static all: FakeSocket[] = [];
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: ((event: { code: number }) => void) | null = null;
  readyState = 0;
  readonly sent: unknown[] = [];
  constructor(readonly url: string) {
    super();
    FakeSocket.all.push(this);
  }
  send(text: string): void {
    this.sent.push(JSON.parse(text));
  }
  close(): void {
    this.breakOff();
  }
  breakOff(code = 1006): void {
    this.readyState = 3;
    this.dispatchEvent(new Event("close"));
    this.onclose?.({ code });
  }
  receive(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
  /** Join the class as follower 3, of whom the service knows an answer or none. */
  join(answer: number | null, question: ClassQuestion | null, driver: number | null = null): void {
    this.readyState = FakeSocket.OPEN;
    this.dispatchEvent(new Event("open"));
    this.onopen?.();
    this.receive({ type: "welcome", role: "follower", number: 3, answer });
    this.state(question, driver);
  }
  state(question: ClassQuestion | null, driver: number | null = null): void {
    const now = { present: 1, is_locked: false, has_ended: false, hands: [], driver, question, puzzle: null };
    this.receive({ type: "class", code: "ABCDEF", ...now });
  }
}

const QUESTION: ClassQuestion = {
  id: 1,
  text: "Is the cell free?",
  options: ["Yes", "No"],
  axis: null,
  is_revealed: false,
  is_closed: false,
  answered: 0,
  counts: null,
  right: null,
};

let room: Classroom;
/** The newest connection of the page. */
const socket = (): FakeSocket => FakeSocket.all.at(-1) as FakeSocket;
const reconnect = (): void => {
  socket().breakOff();
  vi.runOnlyPendingTimers();
};

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("WebSocket", FakeSocket);
  FakeSocket.all = [];
  room = new Classroom("ABCDEF", true);
});

afterEach(() => {
  room.leave();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("an answer that did not arrive is sent again after a reconnect, and not once it is known", () => {
  socket().join(null, QUESTION);
  expect(socket().url).toMatch(/\/api\/classes\/ABCDEF\/stream\?follows=true$/);
  socket().breakOff();
  room.give(1);
  expect(room.answer.value).toEqual({ question: 1, value: 1 });
  vi.runOnlyPendingTimers();
  socket().join(null, QUESTION);
  expect(socket().sent).toEqual([{ type: "answer", question: 1, value: 1 }]);
  socket().state({ ...QUESTION, answered: 1 });
  reconnect();
  socket().join(1, QUESTION);
  expect(socket().sent).toEqual([]);
});

test("after the reveal the answer is the one that the service has", () => {
  socket().join(null, QUESTION);
  room.give(0);
  socket().state({ ...QUESTION, answered: 1, is_revealed: true, is_closed: true, counts: [1, 0] });
  expect(room.answer.value).toEqual({ question: 1, value: 0 });
  socket().breakOff();
  room.give(1);
  vi.runOnlyPendingTimers();
  socket().join(0, { ...QUESTION, answered: 1, is_revealed: true, is_closed: true, counts: [1, 0] });
  expect(socket().sent).toEqual([]);
  expect(room.answer.value).toEqual({ question: 1, value: 0 });
});

test("another question has no answer yet", () => {
  socket().join(1, QUESTION);
  expect(room.answer.value).toEqual({ question: 1, value: 1 });
  socket().state({ ...QUESTION, id: 2 });
  expect(room.answer.value).toBeNull();
});

test("a raised hand is raised again after a reconnect, until the robot was handed over", () => {
  socket().join(null, null);
  room.raise(true);
  reconnect();
  socket().join(null, null);
  expect(socket().sent).toEqual([{ type: "raise", value: true }]);
  socket().state(null, 3);
  socket().state(null);
  expect(room.asksForRobot.value).toBe(false);
  reconnect();
  socket().join(null, null);
  expect(socket().sent).toEqual([]);
});

test("a page that a newer server asks to reload says so, and connects no more", () => {
  socket().receive({ type: "hello", protocol: "gridbloom.v4" });
  expect(room.isOutdated.value).toBe(true);
  vi.runAllTimers();
  dispatchEvent(new Event("online"));
  expect(FakeSocket.all).toHaveLength(1);
});

test("the lecturer's page has the answers before the reveal only if they are looked at, and not the right one", () => {
  const asked = { ...QUESTION, answered: 3, counts: [1, 2], right: 1 };
  socket().join(null, asked);
  expect(room.question.value).toEqual({ ...asked, counts: null, right: null });
  room.lookedAt.value = asked.id;
  expect(room.question.value).toEqual({ ...asked, right: null });
  socket().state({ ...asked, id: 2 });
  expect(room.question.value?.counts).toBeNull();
  socket().state({ ...asked, id: 2, is_revealed: true, is_closed: true });
  expect(room.question.value).toEqual({ ...asked, id: 2, is_revealed: true, is_closed: true });
});

test.each([
  ["/lecture.html?present", 1],
  ["/lecture.html?speaker=1", 0], // connected, it would be the lecturer's page once that of the slides is closed
])("the lecturer's window %s connects to the open class %d times", async (address, times) => {
  const ask = vi.fn(() => Promise.resolve(new Response(null, { status: 503 })));
  vi.stubGlobal("fetch", ask);
  localStorage.setItem("gridbloom.class", "ABCDEF");
  history.replaceState(null, "", address);
  vi.resetModules();
  await import("./classroom");
  expect(ask).toHaveBeenCalledTimes(times);
  history.replaceState(null, "", "/");
  localStorage.clear();
});
