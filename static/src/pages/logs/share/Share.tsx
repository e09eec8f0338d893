import type { SharedView } from "../../../render/view";
import { MakePuzzle } from "../../../tools/puzzle/MakePuzzle";
import type { Shown } from "./links";
import { ShareLinks } from "./ShareLinks";

const TEXT =
  "A link opens what you see now: moment, map, views, measured lines and chosen note. Whoever opens it can play, change " +
  "parameters and ask why in a session of their own, but cannot delete or download the log, or open other logs. The " +
  "link works until you revoke it.";

interface ShareProps {
  readonly session: string;
  /** The visible part of the map; null for all of it. */
  readonly sharedView: () => SharedView | null;
  /** Other state of the page that a link contains. */
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
