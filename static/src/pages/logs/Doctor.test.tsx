import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, describe, expect, it, test, vi } from "vitest";
import { Store } from "../../store/store";
import type { LogEvent } from "../../wire/http";
import type { Command } from "../../wire/protocol";
import { confidenceLabel, Events, examine, isLongEnough, measureOf, momentsOf, standsStill, wellLabel } from "./Doctor";
import { PUSH } from "./push.fixture";

// @vitest-environment happy-dom

afterEach(() => render(null, document.body));

test("going to an event pauses a log that plays", () => {
  const sent: Command[] = [];
  const store = new Store((command) => sent.push(command) > 0);
  act(() => render(<Events events={[PUSH]} store={store} />, document.body));
  document.querySelector("button")?.click();
  expect(sent).toEqual([{ type: "pause" }, { type: "seek", index: 367 }]);
});

test("an event is told with its end where it lasts", () => {
  const store = new Store(() => true);
  const slip: LogEvent = { ...PUSH, kind: "slipped", until_s: 75.25, what: "the wheels measured 0.40 m." };
  act(() => render(<Events events={[PUSH, slip]} store={store} />, document.body));
  expect([...document.querySelectorAll("p .quiet")].map((element) => element.textContent)).toEqual([
    "The robot moved 0.40 m to its left, which the wheels did not measure.",
    "Until 1:15.250 the wheels measured 0.40 m.",
  ]);
});

test("an event is measured in metres, degrees or seconds", () => {
  const of = (change: Partial<LogEvent>): string => measureOf({ ...PUSH, ...change });
  expect(of({})).toBe("0.40 m left");
  expect(of({ direction: null, distance_m: 0.01, turned_rad: -Math.PI / 6 })).toBe("30°");
  expect(of({ kind: "slipped", direction: "behind" })).toBe("0.40 m");
  expect(of({ kind: "clock", step_s: -1.5 })).toBe("−1.50 s");
  expect(of({ kind: "gap", until_s: 77.65 })).toBe("4.25 s");
  expect(of({ kind: "lifted", distance_m: null })).toBe("");
});

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

test("the best six moments of a finding are listed in the order of time", () => {
  const scans = [40, 35, 36, 37, 38, 39, 1];
  const moments = momentsOf({ scans, seconds: scans.map((scan) => scan / 5) });
  expect(moments.map(({ scan }) => scan)).toEqual([35, 36, 37, 38, 39, 40]);
  expect(moments[0]?.seconds).toBe(7);
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

describe("poses at one place", () => {
  it("are those of a log that states none", () => {
    expect(standsStill([])).toBe(false);
    expect(standsStill([[1, 2]])).toBe(false);
    expect(
      standsStill([
        [0, 0],
        [0, 0],
        [0, 0],
      ]),
    ).toBe(true);
    expect(
      standsStill([
        [0, 0],
        [0, 0.001],
      ]),
    ).toBe(false);
  });
});
