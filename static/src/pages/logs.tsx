import "../style/index.css";
import "../style/logs.css";
import { signal } from "@preact/signals";
import { render } from "preact";
import { Button } from "../ui/Button";
import { ConfirmDialog } from "../ui/Dialog";
import { SiteHeader } from "../ui/SiteHeader";
import { Toasts } from "../ui/Toast";
import { Library } from "./logs/Library";
import { openSession } from "./logs/library";
import { Viewer } from "./logs/Viewer";

/** What the address says: `?log=ID&session=ID`. */
interface Place {
  readonly log: string | null;
  readonly session: string | null;
}

function placeOf(search: string): Place {
  const query = new URLSearchParams(search);
  return { log: query.get("log"), session: query.get("session") };
}

const place = signal<Place>(placeOf(location.search));
const failure = signal<string | null>(null);

function go({ log, session }: Place, replace = false): void {
  const query = new URLSearchParams();
  if (log) query.set("log", log);
  if (session) query.set("session", session);
  const address = query.size > 0 ? `?${query}` : location.pathname;
  if (replace) history.replaceState(null, "", address);
  else history.pushState(null, "", address);
  place.value = { log, session };
  if (!log && !session) document.title = "Logs · Gridbloom";
}

/** Begin a session on a log; an address that names only the log gets its session in place. */
async function open(log: string, replace: boolean): Promise<void> {
  failure.value = null;
  go({ log, session: null }, replace);
  try {
    const session = await openSession(log);
    if (place.peek().log === log) go({ log, session }, true);
  } catch (error) {
    failure.value = error instanceof TypeError ? "The server does not answer." : (error as Error).message;
  }
}

addEventListener("popstate", () => {
  failure.value = null;
  place.value = placeOf(location.search);
  resume();
});

function resume(): void {
  const { log, session } = place.peek();
  if (log && !session) void open(log, true);
}

const close = (): void => go({ log: null, session: null });

function Page() {
  const { log, session } = place.value;
  if (session) {
    return (
      <Viewer key={session} session={session} onClose={close} onGone={() => (log ? void open(log, true) : close())} />
    );
  }
  if (!log) return <Library onOpen={(chosen) => void open(chosen.id, false)} />;
  if (failure.value !== null) {
    return (
      <div class="viewer-message" role="alert">
        <h1>This log does not open</h1>
        <p class="prose">{failure.value}</p>
        <div class="actions">
          <Button kind="primary" icon="restart" onClick={() => void open(log, true)}>
            Try again
          </Button>
          <Button onClick={close}>All logs</Button>
        </div>
      </div>
    );
  }
  return (
    <div class="viewer-message" role="status">
      <p class="prose">Opening the log …</p>
      <div class="progress waiting wide">
        <span />
      </div>
    </div>
  );
}

resume();
render(
  <>
    <SiteHeader current="logs" />
    <main>
      <Page />
    </main>
    <ConfirmDialog />
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
