/** The session kinds of the pages; for another kind a page is outdated. */

export interface SessionKind {
  /** Whether the user can drive the robot. */
  readonly isDriven: boolean;
}

export const KINDS: Record<string, SessionKind> = {
  simulation: { isDriven: true },
  log: { isDriven: false },
};
