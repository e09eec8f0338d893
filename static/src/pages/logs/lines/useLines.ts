import { useComputed, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { showAnswer } from "../../../ui/browser/attempts";
import { ask } from "../../../wire/ask";
import type { ShownLines } from "../../../wire/http";
import type { ContentsOfSession } from "../contents/useContents";
import type { LinesState } from "./lines";

/** Formats of logs that contain more than scans, by the server's names: ROS recordings and CARMEN. */
const RECORDING = /^(MCAP|ROS |CARMEN)/;

/**
 * The lines of a session's recording, initially those of a link `shown`. They are requested when the log is opened, for
 * the marks on the time slider; if its contents are not known, the recording is read for that.
 */
export function useLines(
  session: string,
  store: Store,
  contents: ContentsOfSession,
  shown: ShownLines | null = null,
): LinesState {
  const state: LinesState = {
    lines: useSignal(null),
    failure: useSignal(null),
    leftOut: useSignal(0),
    least: useSignal(shown?.least ?? 0),
    node: useSignal(shown?.node ?? ""),
    text: useSignal(shown?.text ?? ""),
    chosen: useSignal(null),
  };
  const isReady = useComputed(() => store.frame.value !== null).value;
  const isRecording = RECORDING.test(store.hello.value?.log?.format ?? "") && isReady;
  const known = contents.state.value.kind;
  useEffect(() => {
    state.lines.value = state.failure.value = state.chosen.value = null;
  }, [session]);
  useEffect(() => {
    if (isRecording && known === "idle") contents.begin();
  }, [session, isRecording, known]);
  useEffect(() => {
    if (known !== "ready") return;
    return showAnswer(
      (ending) => ask("GET /api/sessions/{session_id}/contents/lines", { session_id: session }, { ending }),
      state.failure,
      (found) => {
        state.leftOut.value = found.left_out;
        state.lines.value = found.lines;
      },
    );
  }, [session, known]);
  return state;
}
