import "../style/index.css";
import "./lab/lab.css";
import { computed, signal, useSignal, useSignalEffect } from "@preact/signals";
import { render } from "preact";
import { useMemo, useRef } from "preact/hooks";
import type { Picture } from "../render/picture/Picture";
import { connect } from "../store/connect";
import type { Store } from "../store/store";
import { ParameterPanel } from "../tools/parameters/ParameterPanel";
import { Profile } from "../tools/profile/Profile";
import { StepNote } from "../tools/steps/Steps";
import { Button } from "../ui/Button";
import { lazy } from "../ui/lazy";
import { Disclosure } from "../ui/Panel";
import { SiteHeader } from "../ui/SiteHeader";
import { Toasts, toast } from "../ui/Toast";
import { Working } from "../ui/Working";
import { exposeHook } from "./debugHook";
import { Connected, Controls } from "./lab/Controls";
import { Downloads, share } from "./lab/Downloads";
import { visibleState } from "./lab/link";
import { type Live, Pictures } from "./lab/Pictures";
import { useReading } from "./lab/reading";
import { keepAddress, openSession, restore } from "./lab/session";
import { replay } from "./worldSession";

const Faults = lazy(async () => (await import("../tools/faults/Faults")).Faults);
const MovingTable = lazy(async () => (await import("../tools/table/MovingTable")).MovingTable);
const Why = lazy(async () => (await import("../tools/why/Why")).Why);

/** The current session; null until the server has opened one. */
const live = signal<Live | null>(null);
const trouble = signal<string | null>(null);
const RETRY_MS = 3000;
/** The map's version before its first tiles arrive. */
const EMPTY_MAP = 1;

async function connectLab(): Promise<void> {
  try {
    const { id, notice, shown } = await openSession();
    const before = live.peek();
    before?.stop();
    stopAddress();
    const connection = connect(id);
    let picture: Picture | null = null;
    onPicture = (made) => {
      picture = made;
    };
    exposeHook(connection, () => picture);
    connection.start();
    // Of a session that has ended the page knows more than the address does: also changes made while disconnected.
    if (shown) restore(connection.store, before ? visibleState(before.store) : shown);
    if (shown && before) connection.store.takeOver(before.store);
    stopAddress = keepAddress(id, connection.store);
    trouble.value = null;
    live.value = { ...connection, id };
    if (notice) toast(notice);
  } catch (error) {
    trouble.value =
      error instanceof TypeError
        ? "The server does not answer. The page tries again by itself."
        : (error as Error).message;
    setTimeout(() => void connectLab(), RETRY_MS);
  }
}

let stopAddress: () => void = () => undefined;
let onPicture: (picture: Picture) => void = () => undefined;

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
      <>
        <ParameterPanel
          table={hello.parameters.table}
          values={store.mapping.values}
          set={(name, value) => store.setParameter(name, value)}
        />
        <Button kind="quiet" icon="restart" onClick={() => store.reset()}>
          Reset to defaults
        </Button>
      </>
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
  // The parts below the pictures take longer to render, and wait until the pictures show a map.
  const isSeen = useSignal(false);
  useSignalEffect(() => {
    if (isSeen.peek() || (live.value?.store.mapVersion.value ?? 0) <= EMPTY_MAP) return;
    requestAnimationFrame(() =>
      setTimeout(() => {
        isSeen.value = true;
      }),
    );
  });
  const below = isSeen.value ? store : null;
  useSignalEffect(() => {
    if (live.value?.status.value !== "gone") return;
    live.value.stop();
    void connectLab();
  });
  useSignalEffect(() => {
    const notice = live.value?.store.notice.value;
    // While the robot is dragged along a wall, a notice for each move would only repeat what is visible.
    if (notice && !(notice.code === "teleport.moved" && live.value?.store.draggedTo.peek())) {
      toast(notice.message, notice.kind);
    }
  });
  return (
    <main class="lab">
      <h1 class="visually-hidden">The lab</h1>
      <div class="lab-bar">
        <Controls store={store} />
        <div class="lab-side">
          <Connected connection={session} />
          <Button icon="link" disabled={!session} onClick={() => session && void share(session.id, session.store)}>
            Share
          </Button>
        </div>
      </div>
      {trouble.value && (
        <p class="lab-trouble" role="alert">
          {trouble.value}
        </p>
      )}
      {replay.value && <Working what="Replaying the link" work={replay.value.work} onCancel={replay.value.cancel} />}
      <Pictures session={session} onPicture={(picture) => onPicture(picture)} />
      {store && <StepNote store={store} />}
      {store?.explainedPoint.value && <Why store={store} />}
      {store && (
        <div class="lab-experiments">
          <Disclosure title="What goes wrong" note="seven faults to switch on">
            <Faults store={store} />
          </Disclosure>
          <Disclosure title="The moving table" note="how long does it stay in the map?">
            <MovingTable store={store} />
          </Disclosure>
        </div>
      )}
      <div class="lab-below">
        <div class="lab-column">
          <section class="lab-profile" aria-label="Inverse sensor model">
            {below && <ProfileBox store={below} />}
          </section>
          <div class="lab-sensor">{below && <Sensor store={below} />}</div>
        </div>
        <div class="lab-column">
          <aside class="lab-settings" aria-label="Parameters">
            {below && <Model store={below} />}
          </aside>
          <div class="lab-takeaway">{session && <Downloads id={session.id} />}</div>
        </div>
      </div>
    </main>
  );
}

void connectLab();
render(
  <>
    <SiteHeader current="lab" />
    <Lab />
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
