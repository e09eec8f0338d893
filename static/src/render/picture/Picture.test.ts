// @vitest-environment happy-dom
import { afterEach, expect, test, vi } from "vitest";
import { watchVisibility } from "../../ui/browser/whenIdle";
import { Picture } from "./Picture";

type Tell = (...inSight: boolean[]) => void;

/** Replace the browser's observers; the returned function reports entries to all that were created. */
function observers(): Tell {
  const callbacks: IntersectionObserverCallback[] = [];
  class Told {
    constructor(callback: IntersectionObserverCallback) {
      callbacks.push(callback);
    }
    observe(): void {}
    disconnect(): void {
      callbacks.length = 0;
    }
  }
  vi.stubGlobal("IntersectionObserver", Told);
  return (...inSight) => {
    const entries = inSight.map((isIntersecting) => ({ isIntersecting }) as IntersectionObserverEntry);
    for (const callback of callbacks) callback(entries, {} as IntersectionObserver);
  };
}

afterEach(() => vi.unstubAllGlobals());

test("of several changes reported at once the newest is used", () => {
  const report = observers();
  const reported: boolean[] = [];
  const stop = watchVisibility(document.body, ({ isIntersecting }) => reported.push(isIntersecting));
  report(true);
  report(false, true);
  report(true, false);
  stop();
  report(true);
  expect(reported).toEqual([true, true, false]);
});

test("a picture that left the screen and returned while the browser was busy is painted again", () => {
  const report = observers();
  let paints = 0;
  const frame = document.createElement("div");
  frame.getBoundingClientRect = () => new DOMRect(0, 0, 20, 10);
  vi.stubGlobal("requestAnimationFrame", (task: FrameRequestCallback) => {
    task(0);
    return 0;
  });
  const picture = new Picture(frame, document.createElement("canvas"), () => {
    paints++;
    return false;
  });
  report(true);
  report(false);
  picture.invalidate();
  const before = paints;
  report(true, false);
  picture.invalidate();
  expect(paints).toBe(before); // out of sight nothing is painted
  report(false, true);
  picture.invalidate();
  expect(paints).toBeGreaterThan(before + 1);
  picture.dispose();
});
