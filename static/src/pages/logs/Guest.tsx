import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Button } from "../../ui/Button";
import { beginShared, type Shared, shared } from "./links";
import { Opening } from "./Opening";
import { Viewer } from "./Viewer";

interface Opened {
  readonly session: string;
  readonly shared: Shared;
}

/** The page of a link: somebody else's view of a log, in a session of one's own. */
export function Guest({ token }: { token: string }) {
  const opened = useSignal<Opened | null>(null);
  const failure = useSignal<string | null>(null);
  const open = async (): Promise<void> => {
    failure.value = null;
    opened.value = null;
    try {
      const what = await shared(token);
      opened.value = { session: await beginShared(token), shared: what };
    } catch (error) {
      failure.value = (error as Error).message;
    }
  };
  /** The session has ended: because nobody looked for long, or because the link was revoked. */
  const look = async (): Promise<void> => {
    try {
      await shared(token);
    } catch (error) {
      opened.value = null;
      failure.value = (error as Error).message;
    }
  };
  useEffect(() => void open(), [token]);

  if (failure.value !== null) {
    return (
      <div class="viewer-message" role="alert">
        <h1>This link does not open</h1>
        <p class="prose">{failure.value}</p>
        <div class="actions">
          <Button icon="restart" onClick={() => void open()}>
            Try again
          </Button>
        </div>
      </div>
    );
  }
  if (!opened.value) return <Opening />;
  const { session, shared: what } = opened.value;
  return (
    <Viewer
      key={session}
      session={session}
      onGone={() => void open()}
      guest={{ look: what.look, onEnded: () => void look() }}
    />
  );
}
