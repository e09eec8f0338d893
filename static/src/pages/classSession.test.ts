import { signal } from "@preact/signals";
import { beforeEach, expect, test, vi } from "vitest";
import type { Live } from "./classSession";

const room = {
  code: "ABCDEF",
  isOver: signal(false),
  own: signal<string | null>(null),
  shown: signal<{ view: { page: string }; stage: number } | null>(null),
  drives: signal(false),
};
const connection = () => ({ stop: vi.fn() });

vi.mock("../store/classroom", () => ({ classroom: signal(room) }));
vi.mock("../store/connect", () => ({
  connect: connection,
  connectToClass: connection,
}));

const { watchClassSession } = await import("./classSession");

beforeEach(() => {
  room.isOver.value = false;
  room.own.value = room.shown.value = null;
});

/** The sessions that the page shows, one after the other. It watches until the end of the tests. */
function watch(): readonly (Live | null)[] {
  const connected: (Live | null)[] = [];
  watchClassSession("lab", (session) => connected.push(session));
  return connected;
}

const ids = (connected: readonly (Live | null)[]) => connected.map((session) => session?.id ?? null);
const show = (page: string, stage: number): void => {
  room.shown.value = { view: { page }, stage };
};

test("a page shows the lecturer's session, a copy of its own, and the lecturer's again", () => {
  const connected = watch();
  show("lab", 1);
  room.own.value = "copy";
  room.own.value = null;
  show("lab", 2);
  show("other", 0);
  expect(ids(connected)).toEqual([null, "stage 1", "copy", "stage 1", "stage 2", null]);
});

test("while the page is loaded that the lecturer has opened, this one keeps what it shows", () => {
  show("lab", 1);
  const connected = watch();
  show("lecture", 0);
  expect(ids(connected)).toEqual(["stage 1"]);
  expect(connected[0]?.stop).toHaveBeenCalledOnce();
});

test("once the class is over the page keeps what it shows, without a connection", () => {
  show("lab", 1);
  const connected = watch();
  expect(connected[0]?.stop).not.toHaveBeenCalled();
  room.isOver.value = true;
  expect(ids(connected)).toEqual(["stage 1"]);
  expect(connected[0]?.stop).toHaveBeenCalledOnce();
});

test("a page that comes after the end shows nothing", () => {
  room.isOver.value = true;
  expect(watch()).toEqual([null]);
});
