import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { openClass } from "../../store/classroom";
import { Button } from "../../ui/Button";

/** Whether an address is reached only by the machine that it is opened on. */
const isLoopback = (address: string): boolean => /^(localhost|127\.[\d.]+|\[::1\])$/.test(new URL(address).hostname);

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
            {isLoopback(found.address) && (
              <p class="class-unreachable" role="alert">
                Only this computer reaches this address. For other devices, start the service with{" "}
                <code>gridbloom serve --class</code>.
              </p>
            )}
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
