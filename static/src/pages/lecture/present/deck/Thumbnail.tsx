import { computed, signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { watchVisibility } from "../../../../ui/browser/visibility";
import { whenIdle } from "../../../../ui/browser/whenIdle";
import { SLIDE } from "../scale";
import { deck, hashOf, LAST_STEP } from "../state";
import type { Slide } from "./deck";
import { drawThumbnail, thumbnailKey, thumbnails } from "./thumbnails";

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
    <span class="deck-thumbnail" ref={box}>
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
