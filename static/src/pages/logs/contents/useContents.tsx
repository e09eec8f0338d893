import { type Signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { ProgressBar } from "../../../ui/ProgressBar";
import { progressText } from "../../../ui/Working";
import { ask as send } from "../../../wire/ask";
import type { ContentsAnswer } from "../../../wire/http";

const POLL_MS = 500;

export type ContentsState =
  | { readonly kind: "reading"; readonly progress: number; readonly since: number }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "cancelled" }
  | { readonly kind: "ready"; readonly contents: ContentsAnswer };

interface ContentsOfSession {
  readonly state: Signal<ContentsState>;
  /** Have the server stop, until `again` is called. */
  readonly cancel: () => void;
  readonly again: () => void;
}

/** The contents of a session's recording, asked for while a group that shows them is open. */
export function useContents(session: string): ContentsOfSession {
  const begun = (): ContentsState => ({ kind: "reading", progress: 0, since: performance.now() });
  const state = useSignal<ContentsState>(begun());
  const attempt = useSignal(0);
  const ending = useRef<() => void>(() => undefined);
  useEffect(() => {
    state.value = begun();
    const abort = new AbortController();
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async (): Promise<void> => {
      try {
        const what = "GET /api/sessions/{session_id}/contents";
        const found = await send(what, { session_id: session }, { ending: abort.signal });
        if (found.state === "reading") {
          const before = state.peek();
          const since = before.kind === "reading" ? before.since : performance.now();
          state.value = { kind: "reading", progress: found.progress, since };
          timer = setTimeout(() => void ask(), POLL_MS);
        } else {
          state.value = { kind: "ready", contents: found };
        }
      } catch (error) {
        if (abort.signal.aborted) return;
        state.value = { kind: "failed", why: (error as Error).message };
      }
    };
    void ask();
    ending.current = () => {
      abort.abort();
      clearTimeout(timer);
    };
    return ending.current;
  }, [session, attempt.value]);
  const cancel = (): void => {
    ending.current();
    state.value = { kind: "cancelled" };
    // Whatever comes of it: without requests the server stops by itself, only later.
    void send("DELETE /api/sessions/{session_id}/contents", { session_id: session }).catch(() => undefined);
  };
  const again = (): void => {
    attempt.value += 1;
  };
  return { state, cancel, again };
}

/** Shows the contents once they are known, and before that how far finding them out is. */
export function WhenKnown({
  session,
  children,
}: {
  readonly session: string;
  readonly children: (contents: ContentsAnswer) => ComponentChildren;
}) {
  const { state, cancel, again } = useContents(session);
  const now = state.value;
  if (now.kind === "ready") return <>{children(now.contents)}</>;
  if (now.kind === "failed") return <p role="alert">{now.why}</p>;
  if (now.kind === "cancelled") {
    return (
      <div class="contents-reading">
        <p class="quiet" role="status">
          Cancelled.
        </p>
        <Button onClick={again}>Go through the recording</Button>
      </div>
    );
  }
  return (
    <div class="contents-reading" role="status">
      <p class="quiet">
        Going through the recording … {/* Hidden from screen readers, which would announce it twice a second. */}
        <span class="number" aria-hidden="true">
          {progressText({ fraction: now.progress, elapsed_s: (performance.now() - now.since) / 1000 })}
        </span>
      </p>
      <ProgressBar fraction={now.progress > 0 ? now.progress : null} isWide />
      <Button onClick={cancel}>Cancel</Button>
    </div>
  );
}
