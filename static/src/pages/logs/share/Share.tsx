import type { SharedView } from "../../../render/view";
import { MakePuzzle } from "../../../tools/puzzle/MakePuzzle";
import type { Shown } from "./links";
import { ShareLinks } from "./ShareLinks";

const TEXT =
  "A link opens what you see: parameters, poses, moment, visible part of the map, views and what they show, comparison, " +
  "measured lines, selected place, open group and chosen note. Everyone who opens it gets a session of their own, in which they can play, change parameters and ask why. They cannot delete or " +
  "download the log or open other logs. The link works until you revoke it.";

interface ShareProps {
  readonly session: string;
  /** The visible part of the map; null for all of it. */
  readonly sharedView: () => SharedView | null;
  /** What else of the page a link shows. */
  readonly shown: () => Promise<Shown>;
}

/** Links to this view of a log, and puzzles made of it. */
export function Share({ session, sharedView, shown }: ShareProps) {
  return (
    <ShareLinks session={session} sharedView={sharedView} shown={shown} text={TEXT}>
      <MakePuzzle session={session} />
    </ShareLinks>
  );
}
