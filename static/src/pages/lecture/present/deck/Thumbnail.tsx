import { computed, signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { isDark } from "../../../../ui/browser/theme";
import { watchVisibility, whenIdle } from "../../../../ui/browser/whenIdle";
import { SLIDE } from "../scale";
import { snapshotOf } from "../slideSnapshot";
import { deck, hashOf, LAST_STEP } from "../state";
import { type Slide, titleOf } from "./deck";
import { SlidePicture } from "./SlidePicture";

/** Width of a picture in pixels: that of the large one beside the list on a screen with a pixel ratio of 2. */
const WIDTH = 608;
/** A slide is drawn once nothing on it has changed for this time and this number of frames. */
const STILL_MS = 120;
const STILL_FRAMES = 2;
/** Longest wait for that. */
const LONGEST_MS = 4000;
/** Number of waits: on a slow machine, the code of a figure may take longer. */
const TRIES = 5;

/** Number of waits for the picture of a slide that ended without it, by the slide's key. */
const tries = signal<ReadonlyMap<string, number>>(new Map());
const triesOf = (key: string): number => tries.value.get(key) ?? 0;

/** The address of each picture by the slide's key; empty if it has none. */
const thumbnails = signal<ReadonlyMap<string, string>>(new Map());

/** The input on which the picture of a slide depends. */
const thumbnailKey = ({ hidden, notes, ...shown }: Slide): string => JSON.stringify([shown, isDark.value]);

/**
 * Resolves when the slide is rendered and has not changed for a while; with false if that took longer than LONGEST_MS.
 */
function still(page: Document): Promise<boolean> {
  return new Promise((resolve) => {
    let changedAt = performance.now();
    let frames = 0;
    // A figure gets its size in one frame and is drawn in the next. On a busy machine each takes a second.
    const isReady = (): boolean =>
      frames > STILL_FRAMES && page.querySelector(".on-slide, .own-slide") !== null && !isBusy(page);
    const finish = (isStill: boolean): void => {
      cancelAnimationFrame(frame);
      clearTimeout(limit);
      observer.disconnect();
      resolve(isStill);
    };
    const look = (): void => {
      frames++;
      if (performance.now() - changedAt >= STILL_MS && isReady()) finish(true);
      else frame = requestAnimationFrame(look);
    };
    const limit = setTimeout(() => finish(isReady()), LONGEST_MS);
    const observer = new MutationObserver(() => {
      changedAt = performance.now();
      frames = 0;
    });
    observer.observe(page.documentElement, { subtree: true, childList: true, attributes: true, characterData: true });
    let frame = requestAnimationFrame(look);
  });
}

/** Whether code of a figure is still loading. A derivation's slide does not show its section's figure. */
const isBusy = (page: Document): boolean =>
  [...page.querySelectorAll(".on-slide :is([aria-busy=true], .figure-awaited)")].some((element) =>
    element.checkVisibility(),
  );

/**
 * Draw the slide that a window of this origin shows, and store the picture under its key, unless it will be tried
 * again.
 */
async function drawThumbnail(key: string, from: Window): Promise<void> {
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
      tries.value = new Map(tries.peek()).set(key, triesOf(key) + 1);
      if (triesOf(key) < TRIES) return;
    }
  } catch {
    // This browser cannot draw pages: the row has no picture.
  }
  thumbnails.value = new Map(thumbnails.peek()).set(key, picture);
}

/** Time without input before the next picture is drawn. */
const IDLE_MS = 50;

/** The key of the selected slide, whose large picture is next to the list. */
const atHand = signal<string | null>(null);
/** Keys of the slides whose rows are in view without a picture. */
const wanted = signal<ReadonlySet<string>>(new Set());
/** The selected slide comes first, then those in view from the top, and last those that were not ready in time. */
const next = computed(() => {
  const keys = [...(atHand.value === null ? [] : [atHand.value]), ...deck.value.slides.map(thumbnailKey)];
  const missing = keys.filter((key) => !thumbnails.value.has(key) && (key === atHand.value || wanted.value.has(key)));
  return missing.toSorted((one, other) => triesOf(one) - triesOf(other))[0];
});

function want(key: string, isWanted: boolean): void {
  if (wanted.peek().has(key) === isWanted) return;
  const keys = new Set(wanted.peek());
  if (isWanted) keys.add(key);
  else keys.delete(key);
  wanted.value = keys;
}

/** The picture of a slide in its row, drawn when the row is first in view. */
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

/** The large picture of the selected slide. If the browser cannot draw pages, it is a page that shows the slide. */
export function LargePicture({ slide, index }: { readonly slide: Slide; readonly index: number }) {
  const key = thumbnailKey(slide);
  const address = thumbnails.value.get(key);
  useEffect(() => {
    atHand.value = key;
    return () => {
      atHand.value = null;
    };
  }, [key]);
  const title = `Picture of “${titleOf(slide)}”`;
  if (address === "") return <SlidePicture hash={hashOf({ index, step: LAST_STEP })} title={title} />;
  return address === undefined ? (
    <div class="slide-picture ghost" aria-busy="true" />
  ) : (
    <img class="slide-picture" src={address} alt={title} />
  );
}

/** Show a slide in the frame, which loads with the first one. */
async function show(frame: HTMLIFrameElement, key: string): Promise<void> {
  const index = deck.peek().slides.findIndex((slide) => thumbnailKey(slide) === key);
  const hash = hashOf({ index, step: LAST_STEP });
  const address = `/lecture.html?present=view${hash}`;
  const inside = frame.src ? frame.contentWindow : null;
  if (inside?.location.hash === hash) return;
  const isShown = new Promise((resolve) =>
    (inside ?? frame).addEventListener(inside ? "hashchange" : "load", resolve, { once: true }),
  );
  if (inside) inside.location.replace(address);
  else frame.src = address;
  await isShown;
}

/** The page in which slides are laid out for their pictures, out of view. */
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
      if (element.contentWindow) await drawThumbnail(key, element.contentWindow);
      isDrawing.value = false;
    });
  }, [key, isDrawing]);
  return (
    <div class="deck-maker" aria-hidden="true" inert>
      <iframe ref={frame} title="Pictures of the slides" tabIndex={-1} width={SLIDE.width} height={SLIDE.height} />
    </div>
  );
}
