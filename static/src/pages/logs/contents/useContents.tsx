import { type Signal, useSignal } from "@preact/signals";
import { type ComponentChildren, createContext } from "preact";
import { useContext, useEffect, useMemo } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { ProgressBar } from "../../../ui/ProgressBar";
import { progressText } from "../../../ui/Working";
import { ask as send } from "../../../wire/ask";
import type { ContentsAnswer } from "../../../wire/http";

const POLL_MS = 500;

export type ContentsState =
  | { readonly kind: "idle" }
  | { readonly kind: "reading"; readonly progress: number; readonly since: number }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "cancelled" }
  | { readonly kind: "ready"; readonly contents: ContentsAnswer };

export interface ContentsOfSession {
  readonly state: Signal<ContentsState>;
  /** Start reading the contents, unless that was started or cancelled. */
  readonly begin: () => void;
  /** Make the server stop until `again` is called. */
  readonly cancel: () => void;
  readonly again: () => void;
}

/** Shared by all views of a log's page, so that cancelling in one cancels in all. */
export const ContentsContext = createContext<ContentsOfSession | null>(null);

/** The contents of a session's recording, requested when `begin` is set. */
export function useContents(session: string): ContentsOfSession {
  const state = useSignal<ContentsState>({ kind: "idle" });
  const made = useMemo(() => contentsOf(session, state), [session]);
  useEffect(() => {
    state.value = { kind: "idle" };
    return made.end;
  }, [made]);
  return made;
}

function contentsOf(session: string, state: Signal<ContentsState>): ContentsOfSession & { readonly end: () => void } {
  let abort = new AbortController();
  let timer: ReturnType<typeof setTimeout> | undefined;
  const ask = async (ending: AbortSignal, since: number): Promise<void> => {
    try {
      const contents = await send("GET /api/sessions/{session_id}/contents", { session_id: session }, { ending });
      if (ending.aborted) return;
      if (contents.state === "reading") {
        state.value = { kind: "reading", progress: contents.progress, since };
        timer = setTimeout(() => void ask(ending, since), POLL_MS);
      } else {
        state.value = { kind: "ready", contents };
      }
    } catch (error) {
      if (!ending.aborted) state.value = { kind: "failed", why: (error as Error).message };
    }
  };
  const end = (): void => {
    abort.abort();
    clearTimeout(timer);
  };
  const again = (): void => {
    end();
    abort = new AbortController();
    const since = performance.now();
    state.value = { kind: "reading", progress: 0, since };
    void ask(abort.signal, since);
  };
  return {
    state,
    begin: () => {
      if (state.peek().kind === "idle") again();
    },
    cancel: () => {
      end();
      state.value = { kind: "cancelled" };
      // The result does not matter: without requests the server stops by itself, only later.
      void send("DELETE /api/sessions/{session_id}/contents", { session_id: session }).catch(() => undefined);
    },
    again,
    end,
  };
}

/** Shows the contents once they are known, and until then the progress. */
export function WhenKnown({ children }: { readonly children: (contents: ContentsAnswer) => ComponentChildren }) {
  const shared = useContext(ContentsContext);
  const now = shared?.state.value;
  useEffect(() => {
    if (now?.kind === "idle") shared?.begin();
  }, [shared, now?.kind]);
  if (!shared || !now || now.kind === "idle") return null;
  const { cancel, again } = shared;
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
