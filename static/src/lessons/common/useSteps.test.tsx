// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { useRef } from "preact/hooks";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";
import { type Scene, scene } from "../stage/scene";
import { useInSight } from "./useSteps";

afterEach(() => vi.unstubAllGlobals());

test("a figure's scene follows while it is seen or printed, and otherwise stays", () => {
  let report: (isIntersecting: boolean) => void = () => {};
  class Told {
    constructor(callback: IntersectionObserverCallback) {
      report = (isIntersecting) =>
        callback([{ isIntersecting } as IntersectionObserverEntry], {} as IntersectionObserver);
    }
    observe(): void {}
    disconnect(): void {}
  }
  vi.stubGlobal("IntersectionObserver", Told);
  const scans = signal(1);
  const current = (): Scene => scene({ scans: scans.value, caption: "" });
  let drawn = 0;
  let shown = 0;
  function Figure() {
    const root = useRef<HTMLDivElement>(null);
    shown = useInSight(root, current).poses.length;
    drawn++;
    return h("div", { ref: root });
  }
  act(() => render(h(Figure, {}), document.body));
  expect(shown).toBe(1);
  act(() => report(true));
  act(() => {
    scans.value = 2;
  });
  expect(shown).toBe(2);
  act(() => report(false));
  const before = drawn;
  act(() => {
    scans.value = 3;
  });
  expect([shown, drawn]).toEqual([2, before]);
  act(() => {
    dispatchEvent(new Event("beforeprint"));
  });
  expect(shown).toBe(3);
  act(() => {
    dispatchEvent(new Event("afterprint"));
  });
  act(() => {
    scans.value = 4;
  });
  expect(shown).toBe(3);
  act(() => report(true));
  expect(shown).toBe(4);
});
