import type { SharedView } from "../../../render/view";
import { MakePuzzle } from "../../../tools/puzzle/MakePuzzle";
import { ShareLinks } from "./ShareLinks";

const TEXT =
  "A link opens the current view: parameters, poses, position in the log and visible part of the map. Everyone who " +
  "opens it gets a session of their own, in which they can play, change parameters and ask why. They cannot delete or " +
  "download the log or open other logs. The link works until you revoke it.";

interface ShareProps {
  readonly session: string;
  /** The visible part of the map; null for all of it. */
  readonly sharedView: () => SharedView | null;
}

/** Links to this view of a log, and puzzles made of it. */
export function Share({ session, sharedView }: ShareProps) {
  return (
    <ShareLinks session={session} sharedView={sharedView} text={TEXT}>
      <MakePuzzle session={session} />
    </ShareLinks>
  );
}
