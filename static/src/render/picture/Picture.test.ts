import { afterEach, expect, test, vi } from "vitest";
import { watchVisibility } from "../../ui/visibility";
import { Picture } from "./Picture";

type Tell = (...inSight: boolean[]) => void;

/** A browser whose observers tell what the test says; the result tells all that were made. */
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

test("of several changes told at once the newest counts", () => {
  const tell = observers();
  const heard: boolean[] = [];
  const stop = watchVisibility(document.body, ({ isIntersecting }) => heard.push(isIntersecting));
  tell(true);
  tell(false, true);
  tell(true, false);
  stop();
  tell(true);
  expect(heard).toEqual([true, true, false]);
});

test("a picture that went and came back while the browser was busy is painted again", () => {
  const tell = observers();
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
  tell(true);
  tell(false);
  picture.invalidate();
  const before = paints;
  tell(true, false);
  picture.invalidate();
  expect(paints).toBe(before); // out of sight nothing is painted
  tell(false, true);
  picture.invalidate();
  expect(paints).toBeGreaterThan(before + 1);
  picture.dispose();
});
