import { beforeEach, expect, test } from "vitest";
import type { BinaryFrame } from "../wire/decodeFrame";
import type { Command, ServerMessage } from "../wire/protocol";
import vectors from "../wire/protocol.vectors.json";
import { type Environment, type Receiver, type Socket, Stream } from "./stream";

class FakeSocket implements Socket {
  binaryType = "";
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: ((event: { code: number }) => void) | null = null;
  onerror: (() => void) | null = null;
  readyState = 0;
  sent: unknown[] = [];
  closed = false;
  send(data: string): void {
    this.sent.push(JSON.parse(data));
  }
  close(): void {
    this.closed = true;
    this.readyState = 3;
  }
  open(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  receive(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
  breakOff(code = 1006): void {
    this.readyState = 3;
    this.onclose?.({ code });
  }
}

class FakeBrowser implements Environment {
  sockets: FakeSocket[] = [];
  waits: { task: () => void; ms: number }[] = [];
  paints: (() => void)[] = [];
  isHidden = false;
  changed: () => void = () => undefined;
  open(): Socket {
    const socket = new FakeSocket();
    this.sockets.push(socket);
    return socket;
  }
  later(task: () => void, ms: number): () => void {
    const wait = { task, ms };
    this.waits.push(wait);
    return () => {
      this.waits = this.waits.filter((other) => other !== wait);
    };
  }
  tick: () => void = () => undefined;
  every(task: () => void): () => void {
    this.tick = task;
    return () => {
      this.tick = () => undefined;
    };
  }
  painted(task: () => void): void {
    this.paints.push(task);
  }
  hidden(): boolean {
    return this.isHidden;
  }
  watch(changed: () => void): () => void {
    this.changed = changed;
    return () => undefined;
  }
  get socket(): FakeSocket {
    return this.sockets.at(-1) as FakeSocket;
  }
  /** Let what the server is asked be answered. */
  async answered(): Promise<void> {
    await Promise.resolve();
    await Promise.resolve();
  }
  /** Let the one wait end; its length. */
  async wait(): Promise<number> {
    await this.answered();
    const [wait] = this.waits.splice(0, 1);
    wait?.task();
    await this.answered();
    return wait?.ms ?? Number.NaN;
  }
  setHidden(hidden: boolean): void {
    this.isHidden = hidden;
    this.changed();
  }
}

class RecordingReceiver implements Receiver {
  messages: ServerMessage[] = [];
  frames: BinaryFrame[] = [];
  forgotten = 0;
  kept: readonly Command[] = [];
  receive(message: ServerMessage): void {
    this.messages.push(message);
  }
  take(frame: BinaryFrame): void {
    this.frames.push(frame);
  }
  opening(): readonly Command[] {
    return this.kept;
  }
  forget(): void {
    this.forgotten++;
    this.kept = [];
  }
}

const hello = {
  type: "hello",
  protocol: "gridbloom.v3",
  session: "s",
  kind: "simulation",
  title: "t",
  epoch_id: "e",
  speeds: [1, 1],
  parameters: { table: [], values: {} },
  sensor: null,
  log: null,
  tables: {},
};
const [tiles] = vectors.frames;
const binary = (hex: string): ArrayBuffer =>
  Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16)).buffer;

let browser: FakeBrowser;
let received: RecordingReceiver;
let gone: boolean;
let stream: Stream;

beforeEach(() => {
  browser = new FakeBrowser();
  received = new RecordingReceiver();
  gone = false;
  stream = new Stream("ws://x", received, () => Promise.resolve(gone), browser);
  stream.start();
});

test("live with the first hello, and nothing is sent before that a first connection does not need", () => {
  expect(stream.status.value).toBe("connecting");
  browser.socket.open();
  expect(browser.socket.sent).toEqual([]);
  browser.socket.receive(hello);
  expect(stream.status.value).toBe("live");
  expect(received.messages.map((message) => message.type)).toEqual(["hello"]);
});

test("a frame is acknowledged after it could be painted, not before", () => {
  browser.socket.open();
  browser.socket.onmessage?.({ data: binary(tiles?.hex ?? "") });
  expect(received.frames.length).toBe(1);
  expect(browser.socket.sent).toEqual([]);
  for (const paint of browser.paints) paint();
  expect(browser.socket.sent).toEqual([{ type: "ack", seq: 1 }]);
});

test("after a cut it comes back with what it has, waiting longer each time", async () => {
  browser.socket.open();
  browser.socket.receive(hello);
  received.kept = [
    { type: "resume", epoch_id: "e", layer: "map", epoch: 4, revision: 99 },
    { type: "subscribe", layers: ["map", "costs"] },
  ];
  browser.socket.breakOff();
  expect(stream.status.value).toBe("reconnecting");
  const waits = [await browser.wait()];
  browser.socket.breakOff();
  waits.push(await browser.wait());
  browser.socket.breakOff();
  waits.push(await browser.wait());
  expect(waits[1]).toBeGreaterThan(waits[0] ?? 0);
  expect(waits[2]).toBeGreaterThan(waits[1] ?? 0);
  browser.socket.open();
  expect(browser.socket.sent).toEqual([
    { type: "resume", epoch_id: "e", layer: "map", epoch: 4, revision: 99 },
    { type: "subscribe", layers: ["map", "costs"] },
  ]);
  browser.socket.receive(hello);
  expect(stream.status.value).toBe("live");
  browser.socket.breakOff();
  expect(await browser.wait()).toBe(waits[0]);
});

test("an acknowledgement that belongs to an older socket is not sent on a newer one", async () => {
  browser.socket.open();
  browser.socket.onmessage?.({ data: binary(tiles?.hex ?? "") });
  browser.socket.breakOff();
  await browser.wait();
  browser.socket.open();
  for (const paint of browser.paints) paint();
  expect(browser.socket.sent).toEqual([]);
});

test("a session that ended is gone, and the stream stops", async () => {
  gone = true;
  browser.socket.breakOff();
  await browser.wait();
  browser.socket.breakOff();
  await browser.wait();
  await Promise.resolve();
  expect(stream.status.value).toBe("gone");
  expect(browser.waits).toEqual([]);
  const count = browser.sockets.length;
  browser.setHidden(true);
  browser.setHidden(false);
  expect(browser.sockets.length).toBe(count);
});

test.each([4404, 4410])("after close code %i the page asks at once whether the session exists", async (code) => {
  gone = true;
  browser.socket.open();
  browser.socket.receive(hello);
  browser.socket.breakOff(code);
  await browser.answered();
  expect([stream.status.value, stream.trouble.value]).toEqual(["gone", "This session has ended."]);
  expect(browser.waits).toEqual([]);
});

test("a session that exists and refuses the page is asked again after longer and longer waits", async () => {
  const waits = [];
  for (let i = 0; i < 4; i++) {
    browser.socket.breakOff(4404);
    expect(browser.sockets.length).toBe(i + 1);
    waits.push(await browser.wait());
    expect(browser.sockets.length).toBe(i + 2);
  }
  expect(waits).toEqual([250, 500, 1000, 2000]);
});

test("a page that is hidden while the server is asked does not connect", async () => {
  browser.socket.breakOff(4404);
  browser.setHidden(true);
  await browser.answered();
  expect([stream.status.value, browser.waits.length, browser.sockets.length]).toEqual(["away", 0, 1]);
});

test("a hidden page has no socket; a page that is seen again has one at once", () => {
  browser.socket.open();
  browser.socket.receive(hello);
  const first = browser.socket;
  browser.setHidden(true);
  expect(first.closed).toBe(true);
  expect(stream.status.value).toBe("away");
  expect(browser.waits).toEqual([]);
  received.kept = [{ type: "resume", epoch_id: "e", layer: "map", epoch: 1, revision: 5 }];
  browser.setHidden(false);
  expect(browser.sockets.length).toBe(2);
  browser.socket.open();
  expect(browser.socket.sent).toEqual([{ type: "resume", epoch_id: "e", layer: "map", epoch: 1, revision: 5 }]);
});

test("a frame that cannot be read starts everything again", async () => {
  browser.socket.open();
  browser.socket.receive(hello);
  received.kept = [{ type: "resume", epoch_id: "e", layer: "map", epoch: 1, revision: 5 }];
  const first = browser.socket;
  browser.socket.onmessage?.({ data: new ArrayBuffer(3) });
  expect(first.closed).toBe(true);
  expect(received.forgotten).toBe(1);
  await browser.wait();
  browser.socket.open();
  expect(browser.socket.sent).toEqual([]);
});

test("commands are not sent without a connection, and send returns false", () => {
  expect(stream.send({ type: "play" })).toBe(false);
  browser.socket.open();
  expect(stream.send({ type: "play" })).toBe(true);
});

test.each([
  ["a message", { type: "weather" }],
  ["a session kind", { ...hello, kind: "slam" }],
])("%s that the page does not know ends the connection for good, with one sentence", (_, message) => {
  const reported: (string | null)[] = [];
  stream.trouble.subscribe((sentence) => reported.push(sentence));
  browser.socket.open();
  const { socket } = browser;
  socket.receive(message);
  expect(stream.status.value).toBe("outdated");
  expect(reported).toEqual([null, "This page is older than the server. Reload the page."]);
  expect(socket.closed).toBe(true);
  browser.setHidden(true);
  browser.setHidden(false);
  expect(browser.waits).toEqual([]);
  expect(browser.sockets).toEqual([socket]);
  expect(received.messages).toEqual([]);
});

test("the stream stops retrying when no frame can be read", async () => {
  for (let i = 0; i < 10 && stream.status.value !== "outdated"; i++) {
    browser.socket.open();
    browser.socket.receive(hello);
    browser.socket.receive({ type: "pong", id: "one", t: 0 });
    await browser.wait();
  }
  expect(stream.status.value).toBe("outdated");
  expect(browser.sockets.length).toBe(3);
});

test.each([
  [1008, "The server closed the connection because this page sent something that is not allowed or too much of it."],
  [4404, "The server refused the connection: the session does not exist any more, or too many browsers watch it."],
  [4408, "The server closed the connection because this page did not answer for a long time."],
  [4410, "This session has ended."],
  [1006, "The server does not answer."],
])("close code %i is shown as a sentence until the server answers again", async (code, sentence) => {
  browser.socket.open();
  browser.socket.receive(hello);
  browser.socket.breakOff(code);
  expect(stream.trouble.value).toBe(`${sentence} The page tries again by itself.`);
  await browser.wait();
  browser.socket.breakOff();
  expect(stream.trouble.value).toBe(`${sentence} The page tries again by itself.`);
  await browser.wait();
  browser.socket.open();
  browser.socket.receive(hello);
  expect(stream.trouble.value).toBeNull();
});

test("a server that sends nothing is asked, and what does not answer is named until it does", () => {
  stream.start();
  browser.socket.open();
  browser.socket.receive(hello);
  browser.tick();
  browser.tick();
  expect(browser.socket.sent).toContainEqual({ type: "ping", id: 0 });
  browser.socket.receive({ type: "pong", id: 0, t: 0 });
  for (let i = 0; i < 2; i++) browser.tick();
  expect(stream.trouble.value).toBeNull();
  browser.tick();
  expect(stream.trouble.value).toContain("The server does not answer");
  browser.socket.receive({ type: "pong", id: 0, t: 0 });
  expect(stream.trouble.value).toBeNull();
});

test("a server that does not accept the connection is named until it does", () => {
  stream.start();
  for (let i = 0; i < 2; i++) browser.tick();
  expect(stream.trouble.value).toBeNull();
  browser.tick();
  expect(stream.trouble.value).toContain("The server does not answer");
  browser.socket.open();
  browser.socket.receive(hello);
  expect(stream.trouble.value).toBeNull();
});
