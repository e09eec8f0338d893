/** Creates a puzzle from the current state of a session, and its link. */

import { useSignal } from "@preact/signals";
import { Button } from "../../ui/Button";
import { useAttempts } from "../../ui/browser/attempts";
import { Choice } from "../../ui/Choice";
import { ask } from "../../wire/ask";
import type { NamedCause } from "../../wire/http";
import "./makePuzzle.css";

const AS_IT_IS: NamedCause = { name: "as-it-is", label: "The fault that this map has now" };

/** A button that opens the choice of the fault, and one that creates the link. */
export function MakePuzzle({ session }: { readonly session: string }) {
  const faults = useSignal<readonly NamedCause[] | null>(null);
  const fault = useSignal(AS_IT_IS.name);
  const address = useSignal<string | null>(null);
  const status = useSignal("");
  const { isBusy, failure, attempt } = useAttempts();
  const open = (): Promise<void> =>
    attempt(async () => {
      faults.value = [AS_IT_IS, ...(await ask("GET /api/puzzles", {})).faults];
    });
  const make = (): Promise<void> =>
    attempt(async () => {
      status.value = "";
      const made = await ask(
        "POST /api/sessions/{session_id}/puzzles",
        { session_id: session },
        { body: { fault: fault.value } },
      );
      address.value = new URL(made.address, location.href).href;
      try {
        await navigator.clipboard.writeText(address.value);
        status.value =
          "Link copied. Whoever opens it solves the puzzle. It is on the page Puzzles, where it can be removed.";
      } catch {
        status.value = "The puzzle is made. Copy its address.";
      }
    });
  return (
    <section class="make-puzzle" aria-label="Make a puzzle">
      {faults.value === null ? (
        <Button disabled={isBusy.value} onClick={() => void open()}>
          Make a puzzle
        </Button>
      ) : (
        <>
          <Choice
            label="Fault to find"
            options={faults.value.map(({ name, label }) => ({ value: name, label }))}
            value={fault.value}
            onChange={(name) => {
              fault.value = name;
              address.value = null;
            }}
          />
          <div class="actions">
            <Button kind="primary" icon="link" disabled={isBusy.value} onClick={() => void make()}>
              Create the link
            </Button>
          </div>
        </>
      )}
      {address.value && (
        <input
          class="field-text"
          readOnly
          aria-label="Address of the puzzle"
          value={address.value}
          onFocus={(event) => event.currentTarget.select()}
        />
      )}
      <p class="quiet" role="status">
        {failure.value ||
          status.value ||
          (faults.value === null && "A map with a hidden fault, for others to find and repair.")}
      </p>
    </section>
  );
}
