import { useSignal } from "@preact/signals";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { Panel } from "../../../ui/Panel";
import { fragmentOf } from "./address";
import "../share.css";

/** The address of what is seen now: the costmap, its topic, and the visible part. */
export function ShareCostmap({ store }: { readonly store: Store }) {
  const said = useSignal("");
  const log = store.hello.value?.log;
  const frame = store.frame.value;
  if (!log || !frame) return null;
  const view = store.viewHeld.value ? store.view.value : null;
  const fragment = fragmentOf({ topic: log.trajectory, index: frame.index, view });
  const address = new URL(`?log=${encodeURIComponent(log.id)}${fragment}`, location.href).href;
  const copy = async (): Promise<void> => {
    try {
      await navigator.clipboard.writeText(address);
      said.value = "Address copied.";
    } catch {
      said.value = "The browser does not allow copying: select the address and copy it.";
    }
  };
  return (
    <Panel title="Share this view">
      <div class="share">
        <p>
          The address opens this costmap of the recording, with the visible part of it, for everyone who may open the
          recording on this service.
        </p>
        <div class="actions">
          <Button kind="primary" icon="link" onClick={() => void copy()}>
            Copy the address
          </Button>
        </div>
        <input
          readOnly
          aria-label="Address of this view"
          value={address}
          onFocus={(event) => event.currentTarget.select()}
        />
        <p role="status" class="quiet">
          {said.value}
        </p>
      </div>
    </Panel>
  );
}
