import { useSignalEffect } from "@preact/signals";
import type { Classroom } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { toast } from "../../ui/Toast";

/** Show why a command to the class was refused. */
export function useRefused(room: Classroom): void {
  useSignalEffect(() => {
    const refused = room.refused.value;
    if (!refused) return;
    toast(refused, "error");
    room.refused.value = null;
  });
}

/** Shown instead of the class's line if the server was replaced by a newer one while the page was open. */
export function OutdatedPage() {
  return (
    <aside class="class-bar-box no-print" aria-label="Class">
      <div class="class-line">
        <p role="alert">This page is older than the server. Reload the page.</p>
        <div class="actions">
          <Button kind="primary" icon="restart" onClick={() => location.reload()}>
            Reload
          </Button>
        </div>
      </div>
    </aside>
  );
}
