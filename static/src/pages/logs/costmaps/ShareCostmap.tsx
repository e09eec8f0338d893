import type { SharedView } from "../../../render/view";
import type { Store } from "../../../store/store";
import { ShareLinks } from "../share/ShareLinks";
import { fragmentOf } from "./address";

const TEXT =
  "A link opens this costmap of the recording, with the visible part of it. Everyone who opens it gets a session of " +
  "their own, in which they can play the recording, read its costs and download each costmap. They cannot delete or " +
  "download the recording or open others. The link works until you revoke it.";

interface ShareCostmapProps {
  readonly store: Store;
  readonly session: string;
  /** The visible part of the costmap; null for all of it. */
  readonly sharedView: () => SharedView | null;
}

/** Links to what is seen now, and its address: the costmap, its topic, and the visible part. */
export function ShareCostmap({ store, session, sharedView }: ShareCostmapProps) {
  const log = store.hello.value?.log;
  const frame = store.frame.value;
  if (!log || !frame) return null;
  const view = store.viewHeld.value ? store.view.value : null;
  const fragment = fragmentOf({ topic: log.trajectory, index: frame.index, view });
  const address = new URL(`?log=${encodeURIComponent(log.id)}${fragment}`, location.href).href;
  return (
    <ShareLinks session={session} sharedView={sharedView} unit="costmap" text={TEXT}>
      <label class="share-address">
        <span>For everyone who may open the recording on this service, its address:</span>
        <input
          class="field-text"
          readOnly
          aria-label="Address of this view"
          value={address}
          onFocus={(event) => event.currentTarget.select()}
        />
      </label>
    </ShareLinks>
  );
}
