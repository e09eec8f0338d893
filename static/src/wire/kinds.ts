/** The session kinds known to the pages; for another kind a page is outdated. */

export interface SessionKind {
  /** Whether the user can drive the robot. */
  readonly isDriven: boolean;
  /** Whether there is a robot whose pose is known. */
  readonly hasRobot: boolean;
}

export const KINDS: Record<string, SessionKind> = {
  simulation: { isDriven: true, hasRobot: true },
  log: { isDriven: false, hasRobot: true },
  volume: { isDriven: false, hasRobot: false },
  map: { isDriven: false, hasRobot: false },
  costmaps: { isDriven: false, hasRobot: false },
};
