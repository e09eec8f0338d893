import { afterEach, expect, test, vi } from "vitest";
import { confidenceLabel, examine, isLongEnough, wellLabel } from "./doctor";

afterEach(() => vi.unstubAllGlobals());

const answering = (status: number, body: unknown): void => {
  vi.stubGlobal("fetch", async (path: string) => {
    expect(path).toMatch(/^\/api\/sessions\/a%2Fb\/doctor\?name=\w+$/);
    return new Response(JSON.stringify(body), { status });
  });
};

test("findings are handed on as the server told them", async () => {
  const body = { trajectory: "scan", findings: [], events: [] };
  answering(200, body);
  expect(await examine("a/b", () => undefined, new AbortController().signal)).toEqual(body);
});

test("a refusal is the server's sentence", async () => {
  answering(422, { code: "doctor.short", message: "A log of 3 scans is too short to judge." });
  await expect(examine("a/b", () => undefined, new AbortController().signal)).rejects.toThrow("too short to judge");
});

test("a log is examined unasked only if the server will not refuse it", () => {
  expect([9, 10].map((n_scans) => isLongEnough({ n_scans, topic: "/scan" }))).toEqual([false, true]);
  expect([19, 20].map((n_scans) => isLongEnough({ n_scans, topic: "/ahead + /astern" }))).toEqual([false, true]);
  expect(isLongEnough(null)).toBe(false);
});

test("surety in words", () => {
  const words = [1, 0.8, 0.7].map((sure) => confidenceLabel({ sure, possible: false }));
  expect(words).toEqual(["certain", "very likely", "likely"]);
  expect(confidenceLabel({ sure: 0.69, possible: true })).toBe("possible");
});

test("poses that do not move are not said to be without problems", () => {
  expect(wellLabel("ground truth", false).join(" ")).toBe("No problems found. Poses: ground truth.");
  const [result, about] = wellLabel("standing still", true);
  expect(result).toBe("No problems found in the readings.");
  expect(about).toContain("drift, delay and mount cannot be checked");
});
