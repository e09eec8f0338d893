/** The kinds of session that the pages know; one that is not here makes a page outdated. */

export interface SessionKind {
  /** Whether the robot goes where a person sends or drives it. */
  readonly isDriven: boolean;
}

export const KINDS: Record<string, SessionKind> = {
  simulation: { isDriven: true },
  log: { isDriven: false },
};
