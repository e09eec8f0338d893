/** A part of a session in the pages: its layers and drawings over the map, and its groups in the docks. */

import type { ComponentChildren } from "preact";
import type { Layer } from "../render/map/renderer";
import type { Brush } from "../render/picture/brush";
import type { Store } from "../store/store";

interface Overlay {
  /** The grids over the map. */
  readonly layers?: (store: Store) => readonly Layer[];
  /** Paint over the layers. */
  readonly paint?: (store: Store, brush: Brush) => void;
  /** Read every signal that both depend on. */
  readonly watch: (store: Store) => void;
}

/** The content of a group. */
export interface PartView {
  readonly store: Store;
  readonly session: string;
}

export interface PartGroup {
  readonly id: string;
  readonly title: string;
  /** The section of the dock, which the page must have. */
  readonly section: string;
  /** The purpose of the group. */
  readonly purpose: string;
  /** Whether it is kept unchanged while another group is open. */
  readonly keeps?: boolean;
  readonly badge?: (view: PartView) => string | null;
  readonly content: (view: PartView) => ComponentChildren;
}

export interface PagePart {
  /** The text shown while the session computes for it, by `what` of the `working` message. */
  readonly computing?: Readonly<Record<string, string>>;
  readonly overlay?: Overlay;
  /** Its groups in the docks of the lab, of a log, and of a file in 3D. */
  readonly lab?: readonly PartGroup[];
  readonly log?: readonly PartGroup[];
  readonly volume?: readonly PartGroup[];
}
