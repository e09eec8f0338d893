// @vitest-environment happy-dom
import { afterEach, expect, test, vi } from "vitest";
import { addressOf, answerIn, ask, fileAddress, fileOf, mayPass, whyAgain } from "./ask";

afterEach(() => vi.unstubAllGlobals());

const answering = (answer: unknown, status = 200) => {
  const sent = vi.fn<(address: string, options: RequestInit) => Promise<Response>>(() =>
    Promise.resolve(new Response(JSON.stringify(answer), { status })),
  );
  vi.stubGlobal("fetch", sent);
  return sent;
};

test("the address has what is named, and the query", async () => {
  const sent = answering({ logs: [] });
  expect(await ask("GET /api/logs/{log_id}", { log_id: "a/b ?" })).toEqual({ logs: [] });
  await ask("GET /api/fleet", {}, { query: { since: 3 } });
  await ask("POST /api/sessions/{session_id}/merge", { session_id: "s" }, { body: { log: "x" } });
  const [first, second, third] = sent.mock.calls;
  expect(first).toEqual(["/api/logs/a%2Fb%20%3F", { method: "GET" }]);
  expect(second?.[0]).toBe("/api/fleet?since=3");
  expect([third?.[0], third?.[1].method, third?.[1].body]).toEqual(["/api/sessions/s/merge", "POST", '{"log":"x"}']);
});

test("a file is sent as it is, and an answer may be a file or nothing", async () => {
  const sent = answering({ values: {} });
  const file = new File(["a: 1"], "amcl.yaml");
  await ask("PUT /api/localization/parameters", {}, { body: file });
  const options = { query: { layout: "ros1" }, body: { laser_max_range: 8 } } as const;
  expect(await (await fileOf("POST /api/localization/amcl.yaml", {}, options)).text()).toBe('{"values":{}}');
  expect(sent.mock.calls).toEqual([
    ["/api/localization/parameters", { method: "PUT", body: file }],
    [
      "/api/localization/amcl.yaml?layout=ros1",
      { method: "POST", headers: { "Content-Type": "application/json" }, body: '{"laser_max_range":8}' },
    ],
  ]);
  expect(await answerIn<"DELETE /api/fleet">(new Response(null, { status: 204 }))).toBeUndefined();
});

test("a file has an address where the service has such a file", () => {
  expect(fileAddress("a/b", "volume.bt")).toBe("/api/sessions/a%2Fb/volume.bt");
  expect(fileAddress("s", "costmap/costmap.pgm")).toBe("/api/sessions/s/costmap/costmap.pgm");
  // @ts-expect-error: another ending
  expect(fileAddress("s", "volume.ply")).toContain("volume.ply");
  // @ts-expect-error: another request
  expect(addressOf("GET /api/logs/{log_id}/map.pgm", { log_id: "x" })).toContain("map.pgm");
});

test("what a request needs, and what it does not take, is checked where it is compiled", async () => {
  const sent = answering({});
  // @ts-expect-error: without its body
  await ask("POST /api/fleet", {});
  // @ts-expect-error: another field
  await ask("POST /api/fleet", {}, { body: { once: true } });
  // @ts-expect-error: another query
  await ask("GET /api/fleet", {}, { query: { until: 3 } });
  // @ts-expect-error: a body where there is none
  await ask("DELETE /api/fleet", {}, { body: {} });
  // @ts-expect-error: without what the address names
  await ask("GET /api/logs/{log_id}", {});
  expect(sent).toHaveBeenCalledTimes(5);
});

test("a refusal is the server's sentence", async () => {
  answering({ code: "log.not_found", message: "There is no such log." }, 404);
  await expect(ask("GET /api/logs/{log_id}", { log_id: "x" })).rejects.toThrow("There is no such log.");
});

test("what may pass is a request that had no answer, too many before it, or no room and memory now", async () => {
  const failure = async (): Promise<unknown> => ask("GET /api/fleet", {}).catch((error: unknown) => error);
  for (const [status, passes] of [
    [404, false],
    [413, false],
    [429, true],
    [500, false],
    [503, true],
  ] as const) {
    answering({ code: "x", message: "The service has no memory left for this now." }, status);
    expect([status, mayPass(await failure())]).toEqual([status, passes]);
  }
  expect(whyAgain(await failure())).toBe(
    "The service has no memory left for this now. The page tries again by itself.",
  );
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
  expect(mayPass(await failure())).toBe(true);
  expect(whyAgain(await failure())).toBe("The server does not answer. The page tries again by itself.");
  expect(mayPass(new Error("a defect of the page"))).toBe(false);
});
