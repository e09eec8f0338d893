/** Makes a puzzle of what a session shows, and its link. */

import { useSignal } from "@preact/signals";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";
import "./makePuzzle.css";

interface Fault {
  readonly name: string;
  readonly label: string;
}

const AS_IT_IS: Fault = { name: "as-it-is", label: "The fault that this map has now" };

async function answered<T>(answer: Response): Promise<T> {
  const body = (await answer.json()) as T & { readonly message?: string };
  if (!answer.ok) throw new Error(body.message ?? `The server answered ${answer.status}.`);
  return body;
}

/** A button that opens the choice of the fault, and one that makes the link. */
export function MakePuzzle({ session }: { readonly session: string }) {
  const faults = useSignal<readonly Fault[] | null>(null);
  const fault = useSignal(AS_IT_IS.name);
  const address = useSignal<string | null>(null);
  const said = useSignal("");
  const isBusy = useSignal(false);
  const attempt = async (work: () => Promise<void>): Promise<void> => {
    isBusy.value = true;
    said.value = "";
    try {
      await work();
    } catch (error) {
      said.value = error instanceof TypeError ? "The server does not answer." : (error as Error).message;
    }
    isBusy.value = false;
  };
  const open = (): Promise<void> =>
    attempt(async () => {
      const found = await answered<{ faults: readonly Fault[] }>(await fetch("/api/puzzles"));
      faults.value = [AS_IT_IS, ...found.faults];
    });
  const make = (): Promise<void> =>
    attempt(async () => {
      const headers = { "Content-Type": "application/json" };
      const body = JSON.stringify({ session, fault: fault.value });
      const made = await answered<{ address: string }>(await fetch("/api/puzzles", { method: "POST", headers, body }));
      address.value = new URL(made.address, location.href).href;
      try {
        await navigator.clipboard.writeText(address.value);
        said.value =
          "Link copied. Whoever opens it solves the puzzle. It is on the page Puzzles, where it can be removed.";
      } catch {
        said.value = "The puzzle is made. Copy its address.";
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
        {said.value || (faults.value === null && "A map with a hidden fault, for others to find and repair.")}
      </p>
    </section>
  );
}
