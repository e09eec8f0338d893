/** Small pictures of the slides, made one at a time when the page is idle, and kept while it is open. */

import { signal } from "@preact/signals";
import { isDark } from "../../../../ui/browser/theme";
import { SLIDE } from "../scale";
import { snapshotOf } from "../slideSnapshot";
import type { Slide } from "./deck";

/** Width of a picture, pixels: sharp on an enlarged page. */
const WIDTH = 320;
/** How long nothing on the slide changes before it is drawn, and how long that is awaited. */
const STILL_MS = 250;
const LONGEST_MS = 4000;
/** How many times that is awaited: on a slow machine the code of a figure may take longer. */
const TRIES = 5;

const tries = new Map<string, number>();

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

/** Whether code of a figure is still fetched. A derivation's slide does not show its section's figure. */
const isBusy = (page: Document): boolean =>
  [...page.querySelectorAll(".on-slide :is([aria-busy=true], .figure-awaited)")].some((one) => one.checkVisibility());

/** Draw the slide that a window of this origin shows, and keep the picture under its key; false: try again later. */
export async function drawThumbnail(key: string, from: Window): Promise<boolean> {
  let picture = "";
  try {
    if (await still(from.document)) {
      picture = await snapshotOf(from.document, {
        ...SLIDE,
        to: WIDTH,
        dark: isDark.peek(),
        omitted: ".lesson:not(.on-slide)",
      });
    } else {
      tries.set(key, (tries.get(key) ?? 0) + 1);
      if ((tries.get(key) ?? 0) < TRIES) return false;
    }
  } catch {
    // This browser does not draw pages: the row stands without a picture.
  }
  thumbnails.value = new Map(thumbnails.peek()).set(key, picture);
  return true;
}
