/**
 * A page within a slide: what it shows goes to the window with the slides, which sends it to the class. That window has
 * the connection to the class, and knows which slide is the present one.
 */

import { signal } from "@preact/signals";
import type { ClassCommand } from "../../wire/protocol";

/** The commands that say what a page shows. */
type Shows = Extract<ClassCommand, { type: "show" | "explain" }>;

/** Says that the page has a note for the visitor, such as why it does not show its map yet. */
interface Note {
  readonly type: "note";
}

/** What takes those commands: a class, or the window with the slides. */
export interface Audience {
  send(command: Shows): void;
}

/** What a page within a slide says, the newest message of each type. */
export type PageInSlide = { readonly [Type in (Shows | Note)["type"]]?: Extract<Shows | Note, { type: Type }> };

const KEY = "gridbloom.shown";

const tell = (command: Shows | Note | null): void => parent.postMessage({ [KEY]: command }, location.origin);

/** The window with the slides that this page is in; null for a page in a window of its own. */
export const slidesAround: Audience | null = parent === window ? null : { send: tell };
// Another page in the same frame shows something else, or nothing that can be followed.
if (slidesAround) addEventListener("pagehide", () => tell(null));

/** Have the window around this page show it although its map is awaited: it has a note for the visitor. */
export function tellOfNote(): void {
  if (slidesAround) tell({ type: "note" });
}

/** By the address of its slide, what the page in each frame shows. */
export const pagesInSlides = signal<ReadonlyMap<string, PageInSlide>>(new Map());

function change(address: string, page: PageInSlide | null): void {
  const pages = new Map(pagesInSlides.peek());
  if (page) pages.set(address, page);
  else pages.delete(address);
  pagesInSlides.value = pages;
}

/** Take what the page in the frame of a slide shows, until the returned function is called. */
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
