import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { confirm } from "../../ui/Dialog";
import type { Look } from "../../view";
import { described, type Link, linksTo, makeLink, revokeLink } from "./links";
import "./share.css";

interface ShareProps {
  readonly session: string;
  readonly log: string;
  /** What part of the map is on show; null for all of it. */
  readonly look: () => Look | null;
}

/** Copy an address; resolves to what came of it. */
async function copied(address: string, said: string): Promise<string> {
  try {
    await navigator.clipboard.writeText(address);
    return said;
  } catch {
    return "The browser does not let this page copy: select the address and copy it.";
  }
}

const absolute = (link: Link): string => new URL(link.address, location.href).href;

const made = ({ created_s }: Link): string =>
  new Date(1000 * created_s).toLocaleString("en", { dateStyle: "medium", timeStyle: "short" });

/** Make links that open exactly this view, see one's own and revoke them. */
export function Share({ session, log, look }: ShareProps) {
  const dialog = useRef<HTMLDialogElement>(null);
  const links = useSignal<readonly Link[] | null>(null);
  const failure = useSignal<string | null>(null);
  const said = useSignal("");
  const busy = useSignal(false);
  const copy = async (address: string, words: string): Promise<void> => {
    said.value = await copied(address, words);
  };
  const refresh = async (): Promise<void> => {
    links.value = await linksTo(log);
  };
  const attempt = async (work: () => Promise<void>): Promise<void> => {
    failure.value = null;
    said.value = "";
    busy.value = true;
    try {
      await work();
    } catch (error) {
      failure.value = (error as Error).message;
    }
    busy.value = false;
  };
  const make = (): Promise<void> =>
    attempt(async () => {
      const link = await makeLink(session, look());
      links.value = [link, ...(links.peek() ?? [])];
      // What the map is compared with is told in the address itself.
      await copy(absolute(link) + location.hash, "The link is copied.");
    });
  const revoke = async (link: Link): Promise<void> => {
    const text = "It opens nothing any more, and the views of all who came by it end.";
    if (!(await confirm("Revoke this link?", text, "Revoke"))) return;
    await attempt(async () => {
      await revokeLink(link.token);
      await refresh();
    });
  };
  const open = (): void => {
    dialog.current?.showModal();
    void attempt(refresh);
  };
  return (
    <>
      <Button icon="link" label="Share this view" onClick={open}>
        <span class="button-text">Share</span>
      </Button>
      <dialog ref={dialog} class="dialog share" aria-labelledby="share-title">
        <header>
          <h2 id="share-title">Share this view</h2>
          <Button kind="quiet" icon="close" label="Close" onClick={() => dialog.current?.close()} />
        </header>
        <p>
          A link opens what you see now: these parameters and poses, this moment of the log, this part of the map.
          Whoever has it looks through a view of their own: they may play it, change parameters and ask cells why. They
          cannot delete the log, take it with them or see another. It works until you revoke it.
        </p>
        <div class="actions">
          <Button kind="primary" icon="link" disabled={busy.value} onClick={() => void make()}>
            Make a link
          </Button>
          <Button
            kind="quiet"
            onClick={() => void copy(location.href, "Copied. Whoever may use this service steers this view with you.")}
          >
            Copy this page to steer together
          </Button>
        </div>
        <p role="status" class="quiet">
          {said.value}
        </p>
        {failure.value && <p role="alert">{failure.value}</p>}
        {links.value && links.value.length > 0 && (
          <section aria-label="Your links to this log">
            <h3>Your links to this log</h3>
            <ul>
              {links.value.map((link) => (
                <li key={link.token}>
                  <div>
                    <strong>{made(link)}</strong>
                    <span class="quiet">{described(link)}</span>
                    <input
                      readOnly
                      aria-label={`Address of the link of ${made(link)}`}
                      value={absolute(link)}
                      onFocus={(event) => event.currentTarget.select()}
                    />
                  </div>
                  <Button kind="quiet" onClick={() => void copy(absolute(link), "The link is copied.")}>
                    Copy
                  </Button>
                  <Button kind="danger" disabled={busy.value} onClick={() => void revoke(link)}>
                    Revoke
                  </Button>
                </li>
              ))}
            </ul>
          </section>
        )}
      </dialog>
    </>
  );
}
