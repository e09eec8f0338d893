// @vitest-environment happy-dom
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { setParameter } from "./common/parameters";
import { Endpoint } from "./endpoint/Endpoint";
import { LATER } from "./later";
import { Pipeline } from "./pipeline/Pipeline";
import { MapHistory } from "./stage/history";

/** The figures whose content follows from a map with the lecture's parameters, and those whose content might. */
const FIGURES = {
  ...Object.fromEntries(Object.entries(LATER).map(([id, { figure }]) => [id, figure])),
  endpoint: Endpoint,
  pipeline: Pipeline,
};

/** Shows a figure by its IntersectionObserver. */
let report: (isIntersecting: boolean) => void = () => {};

beforeEach(() => {
  class Observer {
    constructor(callback: IntersectionObserverCallback) {
      const before = report;
      report = (isIntersecting) => {
        before(isIntersecting);
        callback([{ isIntersecting } as IntersectionObserverEntry], {} as IntersectionObserver);
      };
    }
    observe(): void {}
    disconnect(): void {}
  }
  vi.stubGlobal("IntersectionObserver", Observer);
});

afterEach(() => {
  render(null, document.body);
  report = () => {};
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

/** Those that make one when they come into sight again. */
const FOLLOWING = ["layers", "path", "endpoint", "pipeline"];

test.each(Object.entries(FIGURES))("%s makes no map for a parameter while it is out of sight", (id, figure) => {
  act(() => render(h(figure, {}), document.body));
  const made = vi.spyOn(MapHistory.prototype, "advance");
  for (const hit of [0.9, 1.1, 1.3]) act(() => setParameter("log_odds_hit", hit));
  expect(made).not.toHaveBeenCalled();
  act(() => report(true));
  if (FOLLOWING.includes(id)) expect(made).toHaveBeenCalled();
});
