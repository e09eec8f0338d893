import { signal } from "@preact/signals";
import { openOne } from "../../store/classroom";
import { toastFailure } from "../../ui/browser/attempts";

/** Whether the lecturer's screen shows the code of the class. */
export const codeIsShown = signal(false);

/** Open a class, and show its code. */
export const openClassHere = (): Promise<void> =>
  toastFailure(async () => {
    await openOne();
    codeIsShown.value = true;
  });
