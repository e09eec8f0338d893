import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Button } from "./Button";

interface Question {
  readonly title: string;
  readonly text: string;
  readonly yes: string;
  readonly answer: (yes: boolean) => void;
}

const question = signal<Question | null>(null);

/** Ask for confirmation; resolves to true if it was given. */
export function confirm(title: string, text: string, yes: string): Promise<boolean> {
  return new Promise((answer) => {
    question.value = { title, text, yes, answer };
  });
}

/** The dialog of {@link confirm}: once on each page that uses it. */
export function ConfirmDialog() {
  const dialog = useRef<HTMLDialogElement>(null);
  const asked = question.value;
  useEffect(() => {
    if (asked && !dialog.current?.open) dialog.current?.showModal();
  }, [asked]);
  const close = (yes: boolean): void => {
    question.peek()?.answer(yes);
    question.value = null;
    dialog.current?.close();
  };
  return (
    <dialog ref={dialog} class="dialog" aria-labelledby="confirm-title" onCancel={() => close(false)}>
      {asked && (
        <>
          <h2 id="confirm-title">{asked.title}</h2>
          <p>{asked.text}</p>
          <div class="dialog-actions">
            <Button onClick={() => close(false)}>Cancel</Button>
            <Button kind="danger" icon="trash" onClick={() => close(true)}>
              {asked.yes}
            </Button>
          </div>
        </>
      )}
    </dialog>
  );
}
