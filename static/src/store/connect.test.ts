// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { connect, connectToClass } from "./connect";

/** A socket that the test closes. */
class FakeSocket extends EventTarget {
  static last: FakeSocket;
  onclose: ((event: { code: number }) => void) | null = null;
  constructor(readonly url: string) {
    super();
    FakeSocket.last = this;
  }
  close(): void {
    // nothing waits for it
  }
}

const server = vi.fn((_path: string) => Promise.resolve({ status: 404 }));

beforeEach(() => {
  server.mockClear();
  vi.stubGlobal("WebSocket", FakeSocket);
  vi.stubGlobal("fetch", server);
});

afterEach(() => {
  vi.unstubAllGlobals();
});

test("a session whose end the server has announced is not asked for", async () => {
  const { start, status } = connect("s");
  start();
  FakeSocket.last.onclose?.({ code: 4410 });
  await vi.waitFor(() => expect(status.value).toBe("gone"));
  expect(server).not.toHaveBeenCalled();
});

test("a session that refuses the page is asked for", async () => {
  const { start, status } = connect("s");
  start();
  FakeSocket.last.onclose?.({ code: 4404 });
  await vi.waitFor(() => expect(status.value).toBe("gone"));
  expect(server).toHaveBeenCalledWith("/api/sessions/s");
});

test("after the end of the session that a class shows, the page asks for the class", async () => {
  const { start, status } = connectToClass("ABCDEF", () => false);
  start();
  FakeSocket.last.onclose?.({ code: 4410 });
  await vi.waitFor(() => expect(status.value).toBe("gone"));
  expect(server).toHaveBeenCalledWith("/api/classes/ABCDEF");
});
