import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { openClass } from "../../store/classroom";
import { Button } from "../../ui/Button";

/** The code of the class, large enough for a hall: as a QR code, as letters, and as an address. */
export function CodeDialog({ isOpen }: { readonly isOpen: Signal<boolean> }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = isOpen.value;
  const found = openClass.value;
  useEffect(() => {
    if (open && found && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open, found]);
  const close = (): void => {
    isOpen.value = false;
  };
  return (
    <dialog class="class-code-dialog" ref={dialog} aria-labelledby="class-code-title" onClose={close}>
      {found && (
        <>
          <h2 id="class-code-title">Follow on your own device</h2>
          <img src={found.qr} alt={`QR code of ${found.address}`} />
          <div>
            <p>
              Scan the code, or open <b>{new URL("/join", found.address).href.replace(/^https?:\/\//, "")}</b> and type
            </p>
            <p class="class-code" role="img" aria-label={`Code ${[...found.code].join(" ")}`}>
              {found.code.slice(0, 3)} {found.code.slice(3)}
            </p>
            <p class="quiet">No account and no name. You see what the lecturer shows and can answer questions.</p>
            <Button kind="primary" onClick={close}>
              Close
            </Button>
          </div>
        </>
      )}
    </dialog>
  );
}
