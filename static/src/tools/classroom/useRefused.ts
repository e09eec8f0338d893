import { useSignalEffect } from "@preact/signals";
import type { Classroom } from "../../store/classroom";
import { toast } from "../../ui/Toast";

/** Tell why a command to the class was refused. */
export function useRefused(room: Classroom): void {
  useSignalEffect(() => {
    const refused = room.refused.value;
    if (!refused) return;
    toast(refused, "error");
    room.refused.value = null;
  });
}
