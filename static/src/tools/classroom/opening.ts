import { signal } from "@preact/signals";
import { openOne } from "../../store/classroom";
import { toast } from "../../ui/Toast";

/** Whether the lecturer's screen shows the code of the class. */
export const codeIsShown = signal(false);

/** Open a class, and show its code. */
export async function openClassHere(): Promise<void> {
  try {
    await openOne();
    codeIsShown.value = true;
  } catch (error) {
    toast((error as Error).message, "error");
  }
}
