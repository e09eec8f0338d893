import { computed, signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { isDark } from "../../../../ui/browser/theme";
import { watchVisibility, whenIdle } from "../../../../ui/browser/whenIdle";
import { SLIDE } from "../scale";
import { snapshotOf } from "../slideSnapshot";
import { deck, hashOf, LAST_STEP } from "../state";
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
const thumbnails = signal<ReadonlyMap<string, string>>(new Map());

/** What the picture of a slide depends on. */
const thumbnailKey = ({ hidden, notes, ...shown }: Slide): string => JSON.stringify([shown, isDark.value]);

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
async function drawThumbnail(key: string, from: Window): Promise<boolean> {
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

/** Time without input before the next picture is made. */
const IDLE_MS = 200;

/** Keys of the slides whose rows are in view and have no picture yet, in the order in which they came into view. */
const wanted = signal<ReadonlySet<string>>(new Set());
const next = computed(() => [...wanted.value].find((key) => !thumbnails.value.has(key)));

function want(key: string, isWanted: boolean): void {
  if (wanted.peek().has(key) === isWanted) return;
  const keys = new Set(wanted.peek());
  if (isWanted) keys.add(key);
  else keys.delete(key);
  wanted.value = keys;
}

/** Have the other slides in view drawn before this one. */
function postpone(key: string): void {
  if (!wanted.peek().has(key)) return;
  want(key, false);
  want(key, true);
}

/** The picture of a slide in its row, made when the row is first in view. */
export function Thumbnail({ slide }: { readonly slide: Slide }) {
  const box = useRef<HTMLSpanElement>(null);
  const key = thumbnailKey(slide);
  const address = thumbnails.value.get(key);
  const isMissing = address === undefined;
  useEffect(() => {
    if (!isMissing || !box.current) return;
    const stop = watchVisibility(box.current, ({ isIntersecting }) => want(key, isIntersecting));
    return () => {
      stop();
      want(key, false);
    };
  }, [key, isMissing]);
  return (
    <span class={isMissing ? "deck-thumbnail ghost" : "deck-thumbnail"} aria-busy={isMissing} ref={box}>
      {address && <img src={address} alt="" />}
    </span>
  );
}

/** Show a slide in the frame, which is loaded with the first one. */
async function show(frame: HTMLIFrameElement, key: string): Promise<void> {
  const index = deck.peek().slides.findIndex((slide) => thumbnailKey(slide) === key);
  const address = `/lecture.html?present=view${hashOf({ index, step: LAST_STEP })}`;
  if (frame.src) {
    frame.contentWindow?.location.replace(address);
    return;
  }
  const loaded = new Promise((resolve) => frame.addEventListener("load", resolve, { once: true }));
  frame.src = address;
  await loaded;
}

/** The page in which the slides are laid out for their pictures, out of sight. */
export function ThumbnailMaker() {
  const frame = useRef<HTMLIFrameElement>(null);
  const isDrawing = useSignal(false);
  const key = isDrawing.value ? undefined : next.value;
  useEffect(() => {
    if (key === undefined) return;
    return whenIdle(IDLE_MS, async () => {
      const element = frame.current;
      if (!element) return;
      isDrawing.value = true;
      await show(element, key);
      if (element.contentWindow && !(await drawThumbnail(key, element.contentWindow))) postpone(key);
      isDrawing.value = false;
    });
  }, [key, isDrawing]);
  return (
    <div class="deck-maker" aria-hidden="true" inert>
      <iframe ref={frame} title="Pictures of the slides" tabIndex={-1} width={SLIDE.width} height={SLIDE.height} />
    </div>
  );
}
