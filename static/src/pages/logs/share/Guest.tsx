import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { mayPass, whyAgain } from "../../../wire/ask";
import type { SessionAnswer, SharedAnswer } from "../../../wire/http";
import { NotOpened } from "../../SessionEnded";
import { CostmapViewer } from "../costmaps/CostmapViewer";
import { opening } from "../library/library";
import { Opening } from "../Opening";
import { Viewer } from "../Viewer";
import { beginShared, shared } from "./links";

interface Opened {
  readonly session: SessionAnswer;
  readonly shared: SharedAnswer;
}

const RETRY_MS = 3000;

/** The page of a shared link: a shared view of a log in a separate session. */
export function Guest({ token }: { token: string }) {
  const opened = useSignal<Opened | null>(null);
  const failure = useSignal<string | null>(null);
  const ending = useRef<AbortController | null>(null);
  /** Open the link. A temporary failure is shown until a later attempt succeeds. */
  const open = async (isRepeated = false): Promise<void> => {
    if (!isRepeated) failure.value = null;
    opened.value = null;
    ending.current?.abort();
    const own = new AbortController();
    ending.current = own;
    try {
      const view = await shared(token);
      opened.value = { session: await beginShared(token, own.signal), shared: view };
      failure.value = null;
    } catch (error) {
      if (ending.current !== own) return; // it is being opened again
      if (own.signal.aborted) failure.value = "Opening it was cancelled.";
      else if (!mayPass(error)) failure.value = (error as Error).message;
      else {
        failure.value = whyAgain(error);
        setTimeout(() => own.signal.aborted || void open(true), RETRY_MS);
      }
    }
  };
  /** Find out why the session has ended: it was idle, or the link was revoked. */
  const checkLink = async (): Promise<void> => {
    try {
      await shared(token);
    } catch (error) {
      opened.value = null;
      failure.value = (error as Error).message;
    }
  };
  useEffect(() => void open(), [token]);

  if (failure.value !== null && opening.value === null) {
    return <NotOpened title="This link was not opened" reason={failure.value} onAgain={() => void open()} />;
  }
  if (!opened.value) {
    return <Opening now={opening.value} what="Opening the log" onCancel={() => ending.current?.abort()} />;
  }
  const { session, shared: view } = opened.value;
  const Kind = session.kind === "costmaps" ? CostmapViewer : Viewer;
  return (
    <Kind
      key={session.id}
      session={session.id}
      onGone={() => void open()}
      guest={{
        view: view.look,
        shown: view.shown,
        examination: view.examination,
        onEnded: () => void checkLink(),
        openClouds: (ending) => beginShared(token, ending, true),
      }}
    />
  );
}
