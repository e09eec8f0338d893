/**
 * The state of the page in the fragment of its address: the history of the world, the view, the pinned and the
 * explained cell, the active faults, the correct map for comparison, the particle filter, and the 3D map.
 */

import type { View } from "../../render/view";
import { type ActiveFaults, NO_ACTIVE_FAULTS } from "../../store/sessionSignals";
import type { Store } from "../../store/store";
import { LIKELIHOOD_FIELD } from "../../tools/localization/model";
import { filterOf } from "../../tools/localization/state";
import { ask } from "../../wire/ask";
import type { Point, Value, Values } from "../../wire/protocol";
import { pack, unpack } from "../packed";
import type { Story } from "../worldSession";

/** What the page shows of a world. */
export interface VisibleState {
  readonly wrong: ActiveFaults;
  /** The view, if the visitor moved it; null for the whole map. */
  readonly view: View | null;
  /** A point in the pinned cell. */
  readonly pinned: Point | null;
  /** A point in the explained cell, and its selected update; null for the newest. */
  readonly why: { readonly at: Point; readonly touch: number | null } | null;
  /** Parameters of the correct map that differ from those of the map; null while it is not shown. */
  readonly right: Values | null;
  /** The particle filter that localizes the robot; null if there is none. It restarts with random poses. */
  readonly filter: { readonly values: Values; readonly map: string; readonly field: boolean } | null;
  /** Parameters of the 3D map and its sensor; null if there is none. It restarts empty. */
  readonly map3d: Values | null;
}

export interface LinkState extends VisibleState {
  readonly story: Story;
}

/** Whether the address names neither a session nor a state, so that a new world is created. */
export const namesNoWorld = (): boolean =>
  !new URLSearchParams(location.search).has("session") && !location.hash.startsWith("#s=");

/** Encode as the characters of an address. */
export const packLink = (shown: LinkState): Promise<string> => pack(shown);

const isNumber = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);

const isPoint = (value: unknown): value is Point =>
  Array.isArray(value) && value.length === 2 && value.every((part) => isNumber(part));

const isValue = (value: unknown): value is Value => typeof value !== "object" && value !== undefined;

const isValues = (values: unknown): values is Values =>
  typeof values === "object" && values !== null && Object.values(values).every(isValue);

/** Decode; null if the text is invalid or incomplete. */
export async function unpackLink(letters: string): Promise<LinkState | null> {
  try {
    const { story, wrong, view, pinned, why, right, filter, map3d } = (await unpack(letters)) as Partial<LinkState>;
    if (typeof story?.world !== "string" || !isNumber(story.seed)) return null;
    const seen = view && isNumber(view.x) && isNumber(view.y) && isNumber(view.scale) && view.scale > 0 ? view : null;
    return {
      story,
      wrong: Array.isArray(wrong?.on) ? wrong : NO_ACTIVE_FAULTS,
      view: seen,
      pinned: isPoint(pinned) ? pinned : null,
      why: isPoint(why?.at) ? { at: why.at, touch: isNumber(why.touch) ? why.touch : null } : null,
      right: isValues(right) ? right : null,
      filter:
        isValues(filter?.values) && typeof filter.map === "string"
          ? { values: filter.values, map: filter.map, field: filter.field === true }
          : null,
      map3d: isValues(map3d) ? map3d : null,
    };
  } catch {
    return null;
  }
}

/** What the page currently shows of the world. */
export function visibleState(store: Store): VisibleState {
  const at = store.explainedPoint.peek();
  const compared = store.compared.peek();
  return {
    wrong: store.activeFaults.peek(),
    view: store.viewHeld.peek() ? store.view.peek() : null,
    pinned: store.pinned.peek(),
    why: at && { at, touch: store.selectedUpdate.peek() },
    // The second map of the moving table depends on when it was started and cannot be restored.
    right: compared && !compared.with_faults ? compared.values : null,
    filter:
      store.part("localization").message.peek()?.is_on === true
        ? {
            values: filterOf(store).values.peek(),
            map: filterOf(store).map.peek(),
            field: store.underlay.peek() === LIKELIHOOD_FIELD,
          }
        : null,
    map3d: store.part("map3d").message.peek()?.is_on === true ? store.part("map3d").values.values.peek() : null,
  };
}

/** The current state: the history of the world and the view. Throws if the server does not answer. */
export async function currentLinkState(id: string, store: Store): Promise<LinkState> {
  const story = await ask("GET /api/sessions/{session_id}/story", { session_id: id });
  return { story, ...visibleState(store) };
}

/** The fragment of an address. */
export const fragmentOf = async (shown: LinkState): Promise<string> => `#s=${await packLink(shown)}`;

/** The group of the dock that is open at first: the one named by the address, else the model's. */
export const groupFromAddress = (fragment: string = location.hash): string =>
  new URLSearchParams(fragment.replace(/^#/, "")).get("group") ?? "model";

/** The state in the address of this page; null if it has none. */
export async function linkFromAddress(fragment: string = location.hash): Promise<LinkState | null> {
  const letters = new URLSearchParams(fragment.replace(/^#/, "")).get("s");
  return letters ? unpackLink(letters) : null;
}
