import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import type { SharedView } from "../../../render/view";
import { Button } from "../../../ui/Button";
import { useAttempts } from "../../../ui/browser/attempts";
import { confirm } from "../../../ui/Dialog";
import { Failure } from "../../../ui/Failure";
import { Panel } from "../../../ui/Panel";
import { described, type Link, linksOf, makeLink, revokeLink, type Shown } from "./links";
import "./share.css";

interface ShareLinksProps {
  readonly session: string;
  /** The visible part of the map; null for all of it. */
  readonly sharedView: () => SharedView | null;
  /** Other state of the page that a link contains. */
  readonly shown?: () => Promise<Shown>;
  /** The sequence that the session shows. */
  readonly unit?: "scan" | "costmap";
  /** What a link opens, and the rights of its guests. */
  readonly text: string;
  /** Other ways to share the view. */
  readonly children?: ComponentChildren;
}

const OWN_LINKS = { scan: "Your links to this log", costmap: "Your links to this recording" };

/** Copy an address; resolves to the message for the visitor. */
async function copied(address: string, said: string): Promise<string> {
  try {
    await navigator.clipboard.writeText(address);
    return said;
  } catch {
    return "The browser does not allow copying: select the address and copy it.";
  }
}

const absolute = (link: Link): string => new URL(link.address, location.href).href;

const made = ({ created_s }: Link): string =>
  new Date(1000 * created_s).toLocaleString("en", { dateStyle: "medium", timeStyle: "short" });

/** Creates links to this view, and lists and revokes the visitor's own. */
export function ShareLinks({ session, sharedView, shown, unit = "scan", text, children }: ShareLinksProps) {
  const links = useSignal<readonly Link[] | null>(null);
  const status = useSignal("");
  const { isBusy, failure, attempt: attempted } = useAttempts();
  const copy = async (address: string, words: string): Promise<void> => {
    status.value = await copied(address, words);
  };
  const refresh = async (): Promise<void> => {
    links.value = await linksOf(session);
  };
  const attempt = (work: () => Promise<void>): Promise<void> => {
    status.value = "";
    return attempted(work);
  };
  const make = (): Promise<void> =>
    attempt(async () => {
      const link = await makeLink(session, sharedView(), (await shown?.()) ?? null);
      links.value = [link, ...(links.peek() ?? [])];
      await copy(absolute(link), "Link copied.");
    });
  const revoke = async (link: Link): Promise<void> => {
    const warning = "The link stops working, and the sessions of everyone who opened it end.";
    if (!(await confirm("Revoke this link?", warning, "Revoke"))) return;
    await attempt(async () => {
      await revokeLink(session, link.token);
      await refresh();
    });
  };
  useEffect(() => void attempt(refresh), [session]);
  return (
    <Panel title="Share this view">
      <div class="share">
        <p>{text}</p>
        <div class="actions">
          <Button kind="primary" icon="link" disabled={isBusy.value} onClick={() => void make()}>
            Create link
          </Button>
          <Button
            kind="quiet"
            onClick={() =>
              void copy(location.href, "Copied. Everyone who may use this service can control this session with you.")
            }
          >
            Copy the address of this session
          </Button>
        </div>
        <p role="status" class="quiet">
          {status.value}
        </p>
        <Failure why={failure.value} />
        {links.value && links.value.length > 0 && (
          <section aria-label={OWN_LINKS[unit]}>
            <h3>{OWN_LINKS[unit]}</h3>
            <ul>
              {links.value.map((link) => (
                <li key={link.token}>
                  <div>
                    <strong>{made(link)}</strong>
                    <span class="quiet">{described(link, unit)}</span>
                    <input
                      class="field-text"
                      readOnly
                      aria-label={`Address of the link of ${made(link)}`}
                      value={absolute(link)}
                      onFocus={(event) => event.currentTarget.select()}
                    />
                  </div>
                  <Button kind="quiet" onClick={() => void copy(absolute(link), "Link copied.")}>
                    Copy
                  </Button>
                  <Button kind="danger" disabled={isBusy.value} onClick={() => void revoke(link)}>
                    Revoke
                  </Button>
                </li>
              ))}
            </ul>
          </section>
        )}
        {children}
      </div>
    </Panel>
  );
}
