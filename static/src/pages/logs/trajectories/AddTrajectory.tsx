import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { addTrajectory } from "./errors";

/** A TUM file brought as one more trajectory of the log, by a button or dropped here. */
export function AddTrajectory({ session }: { readonly session: string }) {
  const input = useRef<HTMLInputElement>(null);
  const said = useSignal<{ readonly text: string; readonly isError: boolean } | null>(null);
  const busy = useSignal(false);
  const over = useSignal(false);
  const add = async (files: FileList | null | undefined): Promise<void> => {
    busy.value = true;
    for (const file of files ?? []) {
      try {
        said.value = { text: `${await addTrajectory(session, file)} was added.`, isError: false };
      } catch (error) {
        said.value = { text: (error as Error).message, isError: true };
      }
    }
    busy.value = false;
  };
  return (
    <section
      class={over.value ? "add-trajectory over" : "add-trajectory"}
      aria-label="Add a trajectory"
      onDragOver={(event) => {
        event.preventDefault();
        over.value = true;
      }}
      onDragLeave={() => {
        over.value = false;
      }}
      onDrop={(event) => {
        event.preventDefault();
        over.value = false;
        void add(event.dataTransfer?.files);
      }}
    >
      <input
        ref={input}
        type="file"
        hidden
        multiple
        aria-label="TUM files"
        onChange={(event) => {
          const chosen = event.currentTarget;
          void add(chosen.files).then(() => {
            chosen.value = "";
          });
        }}
      />
      <Button icon="upload" disabled={busy.value} onClick={() => input.current?.click()}>
        Add a TUM file
      </Button>
      <span class="quiet">or drop it here to add a trajectory to this log.</span>
      {said.value && <p role={said.value.isError ? "alert" : "status"}>{said.value.text}</p>}
    </section>
  );
}
