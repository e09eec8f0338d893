/** The state of the page in a link in addition to the visible part of the map, and its restoration. */

import { effect, type Signal } from "@preact/signals";
import type { RefObject } from "preact";
import type { Picture } from "../../../render/picture/Picture";
import { framed, type SharedView } from "../../../render/view";
import { inUtc } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { measuringOf } from "../../../tools/measure/measuring";
import { selectionOf } from "../../../tools/scene/selection";
import { type Layout, written } from "../../../ui/stage/layout";
import type { DoctorAnswer, SessionAnswer } from "../../../wire/http";
import type { FieldsState } from "../fields/useFields";
import type { LinesState } from "../lines/lines";
import type { TimelinePlotsState } from "../plots/timelinePlots";
import type { Solid } from "../views/solid";
import type { Shown } from "./links";

/** A visitor with a shared link: the initial view, and a callback for the end of the session. */
export interface GuestOfLink {
  readonly view: SharedView | null;
  readonly shown?: Shown | null;
  /** The findings shown to the sender; null if the log had not been examined. */
  readonly examination?: DoctorAnswer | null;
  readonly onEnded: () => void;
  /** Start a session on the point clouds of the log. */
  readonly openClouds: (ending: AbortSignal) => Promise<SessionAnswer>;
}

/** The visitor's view, if they moved it: otherwise the link shows everything on any screen. */
export function sharedViewOf(store: Store, picture: RefObject<Picture | null>): SharedView | null {
  const view = store.view.peek();
  const size = picture.current?.size;
  return store.viewHeld.peek() && view && size ? { ...view, width: size.width, height: size.height } : null;
}

/** Show the shared part of the map as soon as the picture has a size. */
export function applySharedView(store: Store, picture: RefObject<Picture | null>, view: SharedView | null): () => void {
  let waiting = 0;
  const wait = (): void => {
    const size = picture.current?.size;
    if (view && size && size.width > 0) store.setView(framed(view, size));
    else if (view) waiting = requestAnimationFrame(wait);
  };
  wait();
  return () => cancelAnimationFrame(waiting);
}

/** The server's limits of each. */
const MOST = { fields: 20, points: 1000, text: 200, comparison: 16_000 };

interface ShownPage {
  readonly store: Store;
  readonly group: string;
  readonly note: string | null;
  readonly layout: Signal<Layout>;
  readonly topic: Signal<string>;
  readonly pictured: Signal<string>;
  readonly fields: FieldsState;
  readonly lines: LinesState;
  readonly plots: TimelinePlotsState;
  readonly solid: Solid;
  /** The comparison as a fragment of an address; "" for none. */
  readonly comparison: string;
}

export async function shownOf(page: ShownPage): Promise<Shown> {
  const { store, fields, lines, plots, solid, comparison } = page;
  const measuring = measuringOf(store);
  const tool = measuring.tool.peek();
  const selected = selectionOf(store).peek();
  return {
    group: page.group,
    note: page.note,
    layout: written(page.layout.peek()),
    message: page.topic.peek() || null,
    picture: page.pictured.peek() || null,
    plots: {
      fields: fields.chosen.peek().slice(0, MOST.fields),
      across: fields.across.peek(),
      zoom: plots.zoom.peek(),
      below: plots.isOpen.peek(),
    },
    lines: {
      least: lines.least.peek(),
      node: lines.node.peek().slice(0, MOST.text),
      text: lines.text.peek().slice(0, MOST.text),
    },
    place: selected?.what === "cell" ? selected.place : null,
    measured: tool && {
      tool,
      points: measuring.points
        .peek()
        .slice(0, MOST.points)
        .map(([x, y, z]) => (z === undefined ? [x, y] : [x, y, z])),
      size: measuring.size.peek(),
    },
    scene: await solid.shown(),
    utc: inUtc.peek(),
    comparison: comparison !== "" && comparison.length <= MOST.comparison ? comparison : null,
  };
}

/** Show the times, the selected place and the measurements of a link. The returned function stops waiting. */
export function applyShown(store: Store, shown: Shown, openGroup: Signal<string>): () => void {
  if (shown.utc !== null) inUtc.value = shown.utc;
  let isDone = false;
  const stop = effect(() => {
    if (isDone || !store.map.value) return;
    isDone = true;
    if (shown.measured) {
      const measuring = measuringOf(store);
      measuring.take(shown.measured.tool);
      measuring.points.value = shown.measured.points;
      measuring.size.value = shown.measured.size;
      measuring.isDone.value = true;
    }
    if (shown.place) {
      store.explain(shown.place);
      if (shown.group) openGroup.value = shown.group; // which an explanation replaces
    }
  });
  return stop;
}
