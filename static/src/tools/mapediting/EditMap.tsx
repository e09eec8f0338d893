/** Saves the current map of a session as one of the visitor's maps, and opens it for editing. */

import { useSignal } from "@preact/signals";
import { Button } from "../../ui/Button";
import { toastFailure } from "../../ui/browser/attempts";
import { ask } from "../../wire/ask";

/** The address at which a map of the library is opened. */
export const mapAddress = (id: string): string => `/logs.html?log=${encodeURIComponent(id)}`;

export function EditMap({ session, name }: { readonly session: string; readonly name: string }) {
  const isBusy = useSignal(false);
  const begin = async (): Promise<void> => {
    isBusy.value = true;
    await toastFailure(async () => {
      const body = { name: `Map of ${name}`.slice(0, 100) };
      const stored = await ask("POST /api/sessions/{session_id}/kept-map", { session_id: session }, { body });
      location.href = mapAddress(stored.id);
    });
    isBusy.value = false;
  };
  return (
    <Button icon="pen" disabled={isBusy.value} onClick={() => void begin()}>
      {isBusy.value ? "Saving the map …" : "Edit this map"}
    </Button>
  );
}
