/** The views of a log's stage. A new view is one entry of `VIEWS`. */

import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { Store } from "../../../store/store";
import type { Comparison } from "../../../tools/compare/comparison";
import { kept } from "../../../ui/browser/kept";
import { lazy } from "../../../ui/lazy";
import type { Preset } from "../../../ui/stage/LayoutChoice";
import { type Layout, layoutOf } from "../../../ui/stage/layout";
import type { StageView } from "../../../ui/stage/Stage";
import type { ContentsAnswer } from "../../../wire/http";
import { OtherMap } from "../compare/OtherMap";
import { FrameTree } from "../contents/FrameTree";
import { Pictures } from "../contents/Pictures";
import { Plots } from "../contents/Plots";
import type { Span } from "../contents/series";
import type { FieldsState } from "../fields/useFields";
import { isCloud } from "../library/describeLog";
import { Lines } from "../lines/Lines";
import type { LinesState } from "../lines/lines";
import { Messages } from "../messages/Messages";
import { Residuals } from "../slam/Residuals";
import type { Solid } from "./solid";
import "./views.css";

const SolidView = lazy(async () => (await import("./SolidView")).SolidView);

interface LogOfView {
  readonly store: Store;
  readonly session: string;
  /** The topic whose messages are shown. */
  readonly topic: Signal<string>;
  /** The topic whose pictures are shown. */
  readonly pictured: Signal<string>;
  readonly comparison: Comparison;
  readonly lines: LinesState;
  readonly fields: FieldsState;
  /** Plot a numeric field of a topic by its path. */
  readonly onPlot: (topic: string, field: string) => void;
  /** The interval that all plots show. */
  readonly zoom: Signal<Span | null>;
  readonly solid: Solid;
}

interface View {
  readonly kind: string;
  readonly title: string;
  /** For a picture, which fills its view and does not scroll. */
  readonly fills?: boolean;
  readonly content: (log: LogOfView) => ComponentChildren;
}

const MAP_VIEW = "map";
export const SOLID_VIEW = "3d";
export const PLOTS_VIEW = "plots";

/** In the order in which they fill a layout; the map, which belongs to the viewer, is first. */
const VIEWS: readonly View[] = [
  { kind: "picture", title: "Pictures", content: (log) => <Pictures {...log} /> },
  { kind: "messages", title: "Messages", content: (log) => <Messages {...log} /> },
  { kind: "lines", title: "Log lines", content: (log) => <Lines {...log} /> },
  { kind: PLOTS_VIEW, title: "Plots", content: (log) => <Plots {...log} /> },
  { kind: SOLID_VIEW, title: "3D", content: (log) => <SolidView {...log} /> },
  {
    kind: "second",
    title: "Second map",
    fills: true,
    content: (log) => <OtherMap {...log} />,
  },
  { kind: "residuals", title: "Residuals", content: (log) => <Residuals {...log} /> },
  { kind: "frames", title: "Frames", content: (log) => <FrameTree {...log} /> },
];

export const MAP_ALONE: Layout = layoutOf("one", [MAP_VIEW]);

/** Whether a recording has images; null until that is known. */
export function hasCamera(contents: ContentsAnswer | null): boolean | null {
  if (!contents) return null;
  const clouds = new Set(contents.topics.filter(({ type }) => isCloud(type)).map(({ name }) => name));
  return contents.pictures.some((name) => !clouds.has(name));
}

/** Initial layouts of a log; those with camera pictures unless it certainly has none. */
export function presetsFor(camera: boolean | null): readonly Preset[] {
  const withCamera: readonly Preset[] = [["Map and camera", layoutOf("beside", [MAP_VIEW, "picture"])]];
  return [
    ["Map", MAP_ALONE],
    ...(camera === false ? [] : withCamera),
    ["Map and 3D", layoutOf("beside", [MAP_VIEW, SOLID_VIEW])],
    ["Two maps", layoutOf("beside", [MAP_VIEW, "second"])],
    ["Moment", layoutOf("four", [MAP_VIEW, camera === false ? "messages" : "picture", "plots", "lines"])],
    ["Diagnosis", layoutOf("four", [MAP_VIEW, "residuals", "plots", "second"])],
  ];
}

/** The layout that this browser used last, as text. */
export const lastLayout = kept("gridbloom.logs.views", "", (value): value is string => typeof value === "string");

/** The kinds of views of a log. */
export const KINDS: readonly string[] = [MAP_VIEW, ...VIEWS.map(({ kind }) => kind)];

/** The views of a log, for the stage; `map` is the content of the first. */
export function viewsOf(log: LogOfView, map: () => ComponentChildren): readonly StageView[] {
  return [
    { kind: MAP_VIEW, title: "Map", content: map },
    ...VIEWS.map(({ kind, title, fills, content }) => ({
      kind,
      title,
      content: () => (fills ? content(log) : <Scrolled kind={kind}>{content(log)}</Scrolled>),
    })),
  ];
}

/** A view of text or pictures that scrolls by itself. */
function Scrolled({ kind, children }: { readonly kind: string; readonly children: ComponentChildren }) {
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
    <div class={`view-scroll kind-${kind}`} tabIndex={0}>
      {children}
    </div>
  );
}
