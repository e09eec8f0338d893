// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Store } from "../../store/store";
import type { Frame, Hello } from "../../wire/protocol";
import { RefusedError } from "../worldSession";
import { fragmentOf, linkFromAddress } from "./link";
import { keepAddress, openSession } from "./session";

const STORY = { world: "room", seed: 5, steps: 700 };
const SHOWN = {
  wrong: { on: [], before: {} },
  view: null,
  pinned: null,
  why: null,
  right: null,
  filter: null,
  map3d: null,
};

/** The answers of the server, by the path of the request; what was sent is noted. */
function serve(answers: Record<string, () => Response | Promise<Response>>): object[] {
  const sent: object[] = [];
  vi.stubGlobal("fetch", async (path: string, options?: { body?: string }) => {
    if (options?.body) sent.push(JSON.parse(options.body));
    return await (answers[path] as () => Response)();
  });
  return sent;
}

const gone = (): Response => Response.json({ message: "There is no such session." }, { status: 404 });

beforeEach(async () => {
  history.replaceState(null, "", `/lab.html?session=old${await fragmentOf({ story: STORY, ...SHOWN })}`);
});
afterEach(() => vi.unstubAllGlobals());

test.each([
  new Response("<html><body><h1>503 Service Unavailable</h1></body></html>", { status: 503 }),
  Response.json({ message: "The service has no room for another session." }, { status: 429 }),
])("a world that cannot be restored now stays in the address", async (answer) => {
  serve({ "/api/sessions/old": gone, "/api/sessions": () => answer });
  await expect(openSession()).rejects.not.toBeInstanceOf(RefusedError);
  expect((await linkFromAddress())?.story).toEqual(STORY);
});

test("a world that the server refuses is replaced by a new one", async () => {
  const answers = [
    Response.json({ message: "The story is too long." }, { status: 413 }),
    Response.json({ id: "new" }, { status: 201 }),
  ];
  serve({ "/api/sessions/old": gone, "/api/sessions": () => answers.shift() as Response });
  const opened = await openSession();
  expect([opened.id, opened.shown]).toEqual(["new", null]);
  expect(opened.notice).toContain("The story is too long.");
});

test("a world that stood still is restored standing still, whatever its story says", async () => {
  const sent = serve({ "/api/sessions/old": gone, "/api/sessions": () => Response.json({ id: "new" }) });
  expect((await openSession(true)).shown?.story).toEqual(STORY);
  expect(sent).toMatchObject([{ playing: false, story: STORY }]);
});

const FRAME = {
  type: "frame",
  t: 1,
  playing: true,
  index: 1,
  count: 1,
  pose: [0, 0, 0],
  ranges: [],
} as unknown as Frame;
const HELLO = { type: "hello", parameters: { table: [], values: {} }, epoch_id: "a" } as unknown as Hello;

test("the address follows a world that is paused or plays, and an answer that comes late does not put it back", async () => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout"] });
  const answers: ((story: object) => void)[] = [];
  serve({
    "/api/sessions/live/story": () =>
      new Promise<Response>((answer) => answers.push((story) => answer(Response.json({ ...STORY, ...story })))),
  });
  const store = new Store(() => true);
  vi.spyOn(store.isReady, "value", "get").mockReturnValue(true);
  store.receive(HELLO);
  store.receive(FRAME);
  const stop = keepAddress("live", store);
  const asked = (): number => {
    vi.runAllTimers();
    return answers.length;
  };
  expect(asked()).toBe(1);
  store.receive({ ...FRAME, t: 2 });
  expect(asked()).toBe(1);
  store.receive({ ...FRAME, t: 30 });
  expect(asked()).toBe(2);
  store.receive({ ...FRAME, t: 31, playing: false });
  expect(asked()).toBe(3);
  const written = vi.spyOn(history, "replaceState");
  const isWritten = (times: number) => vi.waitFor(() => expect(written).toHaveBeenCalledTimes(times));
  answers[2]?.({ steps: 3 });
  await isWritten(1);
  answers[0]?.({ steps: 1 });
  answers[1]?.({ steps: 2 });
  store.receive({ ...FRAME, t: 31, playing: false, index: 2 });
  expect(asked()).toBe(4);
  answers[3]?.({ steps: 4 });
  const steps = async (): Promise<unknown> => (await linkFromAddress())?.story.steps;
  await vi.waitFor(async () => expect(await steps()).toBe(4));
  expect(written).toHaveBeenCalledTimes(2);
  stop();
  vi.useRealTimers();
});
