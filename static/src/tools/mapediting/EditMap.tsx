/** Keeps the present map of a session as a map of the visitor's own, and opens it to be edited. */

import { useSignal } from "@preact/signals";
import { Button } from "../../ui/Button";
import { toast } from "../../ui/Toast";

/** Where a map of the library is opened. */
export const mapAddress = (id: string): string => `/logs.html?log=${encodeURIComponent(id)}`;

export function EditMap({ session, name }: { readonly session: string; readonly name: string }) {
  const isBusy = useSignal(false);
  const begin = async (): Promise<void> => {
    isBusy.value = true;
    try {
      const answer = await fetch(`/api/sessions/${encodeURIComponent(session)}/kept-map`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ name: `Map of ${name}`.slice(0, 100) }),
      });
      const body = (await answer.json()) as { id?: string; message?: string };
      if (answer.ok && body.id) location.href = mapAddress(body.id);
      else toast(body.message ?? `The server answered ${answer.status}.`, "error");
    } catch {
      toast("The server does not answer.", "error");
    }
    isBusy.value = false;
  };
  return (
    <Button icon="pen" disabled={isBusy.value} onClick={() => void begin()}>
      {isBusy.value ? "Saving the map …" : "Edit this map"}
    </Button>
  );
}
