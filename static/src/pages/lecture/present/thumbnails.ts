/** Small pictures of the slides, made one at a time when the page is idle, and kept while it is open. */

import { signal } from "@preact/signals";
import { isDark } from "../../../ui/theme";
import type { Slide } from "./deck";
import { SLIDE } from "./scale";
import { snapshotOf } from "./slideSnapshot";

/** Width of a picture, pixels: sharp on an enlarged page. */
const WIDTH = 320;
/** How long nothing on the slide changes before it is drawn, and how long that is awaited. */
const STILL_MS = 250;
const LONGEST_MS = 4000;

/** The address of each picture by the slide's key; empty where there is none. */
export const thumbnails = signal<ReadonlyMap<string, string>>(new Map());

/** What the picture of a slide depends on. */
export const thumbnailKey = ({ hidden, notes, ...shown }: Slide): string => JSON.stringify([shown, isDark.value]);

/** Resolves when the slide is there and has been still for a while; with false if it was not after LONGEST_MS. */
function still(page: Document): Promise<boolean> {
  return new Promise((resolve) => {
    let timer: ReturnType<typeof setTimeout>;
    const finish = (isStill: boolean): void => {
      clearTimeout(timer);
      clearTimeout(limit);
      observer.disconnect();
      resolve(isStill);
    };
    const isComing = (): boolean => page.querySelector(".on-slide, .own-slide") === null || isBusy(page);
    const wait = (): void => {
      clearTimeout(timer);
      timer = setTimeout(() => (isComing() ? wait() : finish(true)), STILL_MS);
    };
    const limit = setTimeout(() => finish(!isComing()), LONGEST_MS);
    const observer = new MutationObserver(wait);
    observer.observe(page.documentElement, { subtree: true, childList: true, attributes: true, characterData: true });
    wait();
  });
}

/** Whether code of the figure is still fetched. */
const isBusy = (page: Document): boolean =>
  page.querySelector(".on-slide :is([aria-busy=true], .figure-awaited)") !== null;

/** Draw the slide that a window of this origin shows, and keep the picture under its key. */
export async function drawThumbnail(key: string, from: Window): Promise<void> {
  let picture = "";
  try {
    if (await still(from.document))
      picture = await snapshotOf(from.document, {
        ...SLIDE,
        to: WIDTH,
        dark: isDark.peek(),
        omitted: ".lesson:not(.on-slide)",
      });
  } catch {
    // This browser does not draw pages: the row stands without a picture.
  }
  thumbnails.value = new Map(thumbnails.peek()).set(key, picture);
}
