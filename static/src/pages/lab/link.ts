/**
 * A link that opens what is on show, packed into the part of an address after `#`: the world's story, the view, the cell
 * that is looked at and why it is asked about, and the map made right beside the wrong one.
 */

import type { View } from "../../render/view";
import { type ActiveFaults, NO_ACTIVE_FAULTS } from "../../store/activeFaults";
import type { Store } from "../../store/store";
import type { Point, Value, Values } from "../../wire/protocol";

/** What happened in a live world, as `/api/sessions/{id}/story` tells it. The server reads it; the page only carries it. */
export type Story = Readonly<Record<string, unknown>> & { readonly world: string; readonly seed: number };

/** What a page shows of a world. */
export interface VisibleState {
  readonly wrong: ActiveFaults;
  /** Where a person has moved the view; null while it shows everything. */
  readonly view: View | null;
  /** The place whose cell a person has pinned. */
  readonly pinned: Point | null;
  /** The place whose cell is explained, and the touch that is looked at; null for the newest. */
  readonly why: { readonly at: Point; readonly touch: number | null } | null;
  /** What the map has otherwise that is made right of the same readings; null while none is beside it. */
  readonly right: Values | null;
}

export interface LinkState extends VisibleState {
  readonly story: Story;
}

async function through(bytes: Uint8Array, transform: GenericTransformStream): Promise<Uint8Array> {
  const stream = new Blob([bytes as Uint8Array<ArrayBuffer>]).stream().pipeThrough(transform as ReadableWritablePair);
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Pack into letters that an address may hold. */
export async function packLink(shown: LinkState): Promise<string> {
  const bytes = await through(new TextEncoder().encode(JSON.stringify(shown)), new CompressionStream("deflate-raw"));
  let letters = "";
  for (const byte of bytes) letters += String.fromCharCode(byte);
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

const isNumber = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);

const isPoint = (value: unknown): value is Point =>
  Array.isArray(value) && value.length === 2 && value.every((part) => isNumber(part));

const isValue = (value: unknown): value is Value => typeof value !== "object" && value !== undefined;

const isValues = (values: unknown): values is Values =>
  typeof values === "object" && values !== null && Object.values(values).every(isValue);

/** Unpack; null for what was never packed, or lost a piece on its way. */
export async function unpackLink(letters: string): Promise<LinkState | null> {
  try {
    const bytes = Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    const text = new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw")));
    const { story, wrong, view, pinned, why, right } = JSON.parse(text) as Partial<LinkState>;
    if (typeof story?.world !== "string" || !isNumber(story.seed)) return null;
    const seen = view && isNumber(view.x) && isNumber(view.y) && isNumber(view.scale) && view.scale > 0 ? view : null;
    return {
      story,
      wrong: Array.isArray(wrong?.on) ? wrong : NO_ACTIVE_FAULTS,
      view: seen,
      pinned: isPoint(pinned) ? pinned : null,
      why: isPoint(why?.at) ? { at: why.at, touch: isNumber(why.touch) ? why.touch : null } : null,
      right: isValues(right) ? right : null,
    };
  } catch {
    return null;
  }
}

/** What the page shows of the world now. */
export function visibleState(store: Store): VisibleState {
  const at = store.asked.peek();
  const compared = store.compared.peek();
  return {
    wrong: store.activeFaults.peek(),
    view: store.viewHeld.peek() ? store.view.peek() : null,
    pinned: store.pinned.peek(),
    why: at && { at, touch: store.touched.peek() },
    // The second map of the moving table began with it and cannot be told.
    right: compared && !compared.with_faults ? compared.values : null,
  };
}

/** What there is now, the world's story and what the page shows of it. Throws where the server does not answer. */
export async function currentLinkState(id: string, store: Store): Promise<LinkState> {
  const answer = await fetch(`/api/sessions/${encodeURIComponent(id)}/story`);
  if (!answer.ok) throw new Error(`The server answered ${answer.status}.`);
  return { story: (await answer.json()) as Story, ...visibleState(store) };
}

/** The part after `#` of an address. */
export const fragmentOf = async (shown: LinkState): Promise<string> => `#s=${await packLink(shown)}`;

/** What the address of this page carries; null for nothing. */
export async function linkFromAddress(fragment: string = location.hash): Promise<LinkState | null> {
  const letters = new URLSearchParams(fragment.replace(/^#/, "")).get("s");
  return letters ? unpackLink(letters) : null;
}
