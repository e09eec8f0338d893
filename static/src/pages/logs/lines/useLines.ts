import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { ask } from "../../../wire/ask";
import type { Line, LinesState } from "./lines";

/** The lines of a session's recording, which {@link loadLines} asks for when they are first shown. */
export function useLines(session: string): LinesState {
  const state: LinesState = {
    lines: useSignal(null),
    failure: useSignal(null),
    leftOut: useSignal(0),
    least: useSignal(0),
    node: useSignal(""),
    text: useSignal(""),
    chosen: useSignal(null),
  };
  useEffect(() => {
    state.lines.value = state.failure.value = state.chosen.value = null;
  }, [session]);
  return state;
}

/** Ask for the lines where they are not known; the contents of the recording are. */
export function useLoadedLines(session: string, { lines, failure, leftOut }: LinesState): readonly Line[] | null {
  useEffect(() => {
    if (lines.peek() !== null) return;
    const abort = new AbortController();
    ask("GET /api/sessions/{session_id}/contents/lines", { session_id: session }, { ending: abort.signal }).then(
      (found) => {
        failure.value = null;
        leftOut.value = found.left_out;
        lines.value = found.lines;
      },
      (error: Error) => {
        if (!abort.signal.aborted) failure.value = error.message;
      },
    );
    return () => abort.abort();
  }, [session]);
  return lines.value;
}
