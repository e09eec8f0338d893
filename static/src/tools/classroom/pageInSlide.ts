/**
 * A page within a slide. What it shows is sent to the window with the slides, which sends it to the class. That window
 * has the connection to the class, and knows the current slide.
 */

import { signal } from "@preact/signals";
import type { ClassCommand } from "../../wire/protocol";

/** The commands about what a page shows. */
type Shows = Extract<ClassCommand, { type: "show" | "explain" }>;

/** Reports that the page has a note for the visitor, such as why it does not show its map yet. */
interface Note {
  readonly type: "note";
}

/** The receiver of those commands: a class, or the window with the slides. */
export interface Audience {
  send(command: Shows): void;
}

/** The newest message of each type from a page within a slide. */
export type PageInSlide = { readonly [Type in (Shows | Note)["type"]]?: Extract<Shows | Note, { type: Type }> };

const KEY = "gridbloom.shown";

const tell = (command: Shows | Note | null): void => parent.postMessage({ [KEY]: command }, location.origin);

/** The window with the slides that contains this page; null for a page in a separate window. */
export const slidesAround: Audience | null = parent === window ? null : { send: tell };
// Another page in the same frame shows something else, or something that cannot be followed.
if (slidesAround) addEventListener("pagehide", () => tell(null));

/** Make the window around this page show it before its map, because it has a note for the visitor. */
export function tellOfNote(): void {
  if (slidesAround) tell({ type: "note" });
}

/** What the page in each frame shows, by the address of its slide. */
export const pagesInSlides = signal<ReadonlyMap<string, PageInSlide>>(new Map());

function change(address: string, page: PageInSlide | null): void {
  const pages = new Map(pagesInSlides.peek());
  if (page) pages.set(address, page);
  else pages.delete(address);
  pagesInSlides.value = pages;
}

/** Receive what the page in the frame of a slide shows, until the returned function is called. */
export function listenToPage(frame: HTMLIFrameElement, address: string): () => void {
  const take = ({ source, origin, data }: MessageEvent): void => {
    if (origin !== location.origin || source !== frame.contentWindow || !(KEY in Object(data))) return;
    const command = data[KEY] as Shows | Note | null;
    change(address, command && { ...pagesInSlides.peek().get(address), [command.type]: command });
  };
  addEventListener("message", take);
  return () => {
    removeEventListener("message", take);
    change(address, null);
  };
}
