// @vitest-environment happy-dom
import { afterEach, expect, test } from "vitest";
import { listenToPage, pagesInSlides } from "./pageInSlide";

const SHOW = { type: "show", view: { page: "lab" }, session: "s1" } as const;
const EXPLAIN = { type: "explain", why: null } as const;

let stop = (): void => undefined;
afterEach(() => stop());

/** Begin to listen to a frame; returns a function with which a window says that it shows something. */
function listening(): (data: unknown, source?: Window | null, origin?: string) => void {
  const frame = { contentWindow: {} } as HTMLIFrameElement;
  stop = listenToPage(frame, "/lab.html");
  return (data, source = frame.contentWindow, origin = location.origin) => {
    dispatchEvent(new MessageEvent("message", { data, source, origin }));
  };
}

test("what the page in a frame shows is known by the address of its slide, until the frame is gone", () => {
  const say = listening();
  say({ "gridbloom.shown": SHOW });
  say({ "gridbloom.shown": EXPLAIN });
  expect(pagesInSlides.value.get("/lab.html")).toEqual({ show: SHOW, explain: EXPLAIN });
  stop();
  expect(pagesInSlides.value.size).toBe(0);
});

test("a page that leaves the frame shows nothing any more", () => {
  const say = listening();
  say({ "gridbloom.shown": SHOW });
  say({ "gridbloom.shown": null });
  expect(pagesInSlides.value.size).toBe(0);
});

test("neither another window nor another host says what a frame shows", () => {
  const say = listening();
  say({ "gridbloom.shown": SHOW }, window);
  say({ "gridbloom.shown": SHOW }, undefined, "https://example.org");
  say("something else");
  expect(pagesInSlides.value.size).toBe(0);
});
