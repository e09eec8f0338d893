import "../style/index.css";
import "./lab.css";
import { computed, signal, useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { render } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { type Connection, connect } from "../connect";
import { exposeHook } from "../debug";
import { Belief } from "../figures/belief";
import type { Picture } from "../figures/picture/Picture";
import { Profile } from "../figures/profile/Profile";
import { Readout } from "../figures/readout";
import { Why } from "../figures/why/Why";
import { TrueWorld } from "../figures/world";
import type { Store } from "../state";
import { Button } from "../ui/Button";
import { ParameterPanel } from "../ui/ParameterPanel";
import { SiteHeader } from "../ui/SiteHeader";
import { Toasts, toast } from "../ui/Toast";
import { Connected, Controls } from "./lab/Controls";
import { useReading } from "./lab/reading";
import { openSession } from "./lab/session";
import { share, Takeaway } from "./lab/Takeaway";

interface Live extends Connection {
  readonly id: string;
}

/** The session on show; null until the server has given one. */
const live = signal<Live | null>(null);
const trouble = signal<string | null>(null);
const RETRY_MS = 3000;

async function begin(): Promise<void> {
  try {
    const { id, notice } = await openSession();
    live.peek()?.stop();
    const connection = connect(id);
    let picture: Picture | null = null;
    onPicture = (made) => {
      picture = made;
    };
    exposeHook(connection, () => picture);
    connection.start();
    trouble.value = null;
    live.value = { ...connection, id };
    if (notice) toast(notice);
  } catch (error) {
    trouble.value =
      error instanceof TypeError ? "The server does not answer; this page goes on trying." : (error as Error).message;
    setTimeout(() => void begin(), RETRY_MS);
  }
}

let onPicture: (picture: Picture) => void = () => undefined;

interface PlateProps {
  readonly title: string;
  readonly note: string;
  readonly actions?: ComponentChildren;
  readonly caption: ComponentChildren;
  readonly children: ComponentChildren;
}

/** A picture with its title above and one line under it. */
function Plate({ title, note, actions, caption, children }: PlateProps) {
  return (
    <section class="plate" aria-label={title}>
      <header class="plate-head">
        <h2>{title}</h2>
        <span class="plate-note">{note}</span>
        {actions}
      </header>
      <div class="plate-picture">{children}</div>
      <div class="plate-caption">{caption}</div>
    </section>
  );
}

function Pictures({ session }: { readonly session: Live | null }) {
  const store = session?.store ?? null;
  const solid = useSignal(false);
  const fit = (): void => {
    if (store) store.viewHeld.value = false;
  };
  return (
    <div class={`plates${solid.value ? " three" : ""}`}>
      <Plate
        title="The world"
        note="as it is"
        actions={<Button kind="quiet" icon="fit" label="Show everything" onClick={fit} />}
        caption={
          <p class="hint">
            Click: the robot goes there. Or drag it
            <span class="hint-keys">
              , or drive with <kbd>W</kbd> <kbd>A</kbd> <kbd>S</kbd> <kbd>D</kbd>
            </span>
            .
          </p>
        }
      >
        {store && <TrueWorld store={store} />}
      </Plate>
      <Plate
        title="The belief"
        note="as the robot has it"
        actions={
          <Button
            kind="quiet"
            icon="cube"
            pressed={solid.value}
            disabled={!session}
            onClick={() => {
              solid.value = !solid.value;
            }}
          >
            3D
          </Button>
        }
        caption={store ? <Readout store={store} /> : null}
      >
        {store && <Belief store={store} onPicture={(picture) => onPicture(picture)} />}
      </Plate>
      {solid.value && session && (
        <Plate
          title="In 3D"
          note="map, robot and world"
          actions={
            <Button
              kind="quiet"
              icon="close"
              label="Close 3D"
              onClick={() => {
                solid.value = false;
              }}
            />
          }
          caption={
            <p class="hint">
              <a href={`/3d?session=${encodeURIComponent(session.id)}`} target="_blank" rel="noopener">
                Open in a tab of its own
              </a>
            </p>
          }
        >
          <iframe class="scene" title="3D view" src={`/scenes/${encodeURIComponent(session.id)}/`} />
        </Plate>
      )}
    </div>
  );
}

function ProfileBox({ store }: { readonly store: Store }) {
  const place = useRef<HTMLDivElement>(null);
  const reading = useReading(store, place);
  const isPointed = useMemo(() => computed(() => store.probe.value !== null), [store]);
  const set = useMemo(() => (name: string, value: number) => store.setParameter(name, value), [store]);
  return (
    <div ref={place}>
      <Profile
        parameters={store.mapping.values}
        setParameter={set}
        reading={reading}
        beamName={isPointed.value ? "the beam towards the pointer" : "the beam straight ahead"}
      />
    </div>
  );
}

function Model({ store }: { readonly store: Store }) {
  const hello = store.hello.value;
  return (
    hello && (
      <ParameterPanel
        table={hello.parameters.table}
        values={store.mapping.values}
        set={(name, value) => store.setParameter(name, value)}
      />
    )
  );
}

function Sensor({ store }: { readonly store: Store }) {
  const table = store.hello.value?.sensor?.table;
  return (
    table && (
      <ParameterPanel table={table} values={store.sensor.values} set={(name, value) => store.setSensor(name, value)} />
    )
  );
}

function Lab() {
  const session = live.value;
  const store = session?.store ?? null;
  useEffect(() => {
    void begin();
  }, []);
  useSignalEffect(() => {
    if (live.value?.status.value !== "gone") return;
    live.value.stop();
    void begin();
  });
  useSignalEffect(() => {
    const notice = live.value?.store.notice.value;
    // While the hand drags the robot along a wall it sees what happens; words would only pile up.
    if (notice && !(notice.code === "teleport.moved" && live.value?.store.carried.peek())) {
      toast(notice.message, notice.kind);
    }
  });
  return (
    <main class="lab">
      <h1 class="visually-hidden">The lab</h1>
      <div class="lab-bar">
        <Controls store={store} />
        <div class="lab-side">
          <Connected status={session?.status ?? null} />
          <Button icon="link" disabled={!session} onClick={() => session && void share(session.id)}>
            Share
          </Button>
        </div>
      </div>
      {trouble.value && (
        <p class="lab-trouble" role="alert">
          {trouble.value}
        </p>
      )}
      <Pictures session={session} />
      {store && <Why store={store} side="left" />}
      <div class="lab-below">
        <div class="lab-column">
          <section class="lab-profile" aria-label="Inverse sensor model">
            {store && <ProfileBox store={store} />}
          </section>
          <div class="lab-row">
            {store && <Sensor store={store} />}
            {session && <Takeaway id={session.id} />}
          </div>
        </div>
        <aside class="lab-settings" aria-label="Parameters">
          {store && <Model store={store} />}
        </aside>
      </div>
    </main>
  );
}

render(
  <>
    <SiteHeader current="lab" />
    <Lab />
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
