import { type Signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { progressText } from "../../../ui/Working";
import { type Contents, contentsAddress, fetchJson } from "./contents";

const POLL_MS = 500;

export type ContentsState =
  | { readonly kind: "reading"; readonly progress: number; readonly since: number }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "ready"; readonly contents: Contents };

/** The contents of a session's recording, asked for while a group that shows them is open. */
export function useContents(session: string): Signal<ContentsState> {
  const state = useSignal<ContentsState>({ kind: "reading", progress: 0, since: performance.now() });
  useEffect(() => {
    const abort = new AbortController();
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async (): Promise<void> => {
      try {
        const { status, body } = await fetchJson<Contents & { progress: number }>(
          contentsAddress(session),
          abort.signal,
        );
        if (status === 202) {
          const before = state.peek();
          const since = before.kind === "reading" ? before.since : performance.now();
          state.value = { kind: "reading", progress: body.progress, since };
          timer = setTimeout(() => void ask(), POLL_MS);
        } else {
          state.value = { kind: "ready", contents: body };
        }
      } catch (error) {
        if (abort.signal.aborted) return;
        const why = error instanceof TypeError ? "The server does not answer." : (error as Error).message;
        state.value = { kind: "failed", why };
      }
    };
    void ask();
    return () => {
      abort.abort();
      clearTimeout(timer);
    };
  }, [session]);
  return state;
}

/** Shows the contents once they are known, and before that how far finding them out is. */
export function WhenKnown({
  session,
  children,
}: {
  readonly session: string;
  readonly children: (contents: Contents) => ComponentChildren;
}) {
  const now = useContents(session).value;
  if (now.kind === "ready") return <>{children(now.contents)}</>;
  if (now.kind === "failed") return <p role="alert">{now.why}</p>;
  return (
    <div class="contents-reading" role="status">
      <p class="quiet">
        Going through the recording … {/* Hidden from screen readers, which would announce it twice a second. */}
        <span class="number" aria-hidden="true">
          {progressText({ fraction: now.progress, elapsed_s: (performance.now() - now.since) / 1000 })}
        </span>
      </p>
      <div class={now.progress > 0 ? "progress wide" : "progress waiting wide"} aria-hidden="true">
        <span style={now.progress > 0 ? { transform: `scaleX(${now.progress})` } : undefined} />
      </div>
    </div>
  );
}
