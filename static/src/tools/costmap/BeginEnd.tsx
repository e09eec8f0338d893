/** Buttons that begin and end the costmap. */

import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { costmapOf } from "./state";

/** A button that begins the costmap after the user has ended it. */
export function Begin({ store }: { readonly store: Store }) {
  if (!costmapOf(store).isEnded.value) return <p class="navigation-note">Computing the costmap …</p>;
  const begin = (): void => {
    costmapOf(store).isEnded.value = false;
  };
  return (
    <Button kind="primary" onClick={begin}>
      Make the costmap
    </Button>
  );
}

export function End({ store }: { readonly store: Store }) {
  return (
    <Button
      kind="quiet"
      onClick={() => {
        costmapOf(store).isEnded.value = true;
        store.send({ type: "costmap", value: false });
      }}
    >
      End the costmap
    </Button>
  );
}
