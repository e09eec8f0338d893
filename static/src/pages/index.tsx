import "../style/index.css";
import "../style/home.css";
import { computed, signal, useSignalEffect } from "@preact/signals";
import { render } from "preact";
import { useEffect } from "preact/hooks";
import { type Connection, connect } from "../connect";
import { Belief } from "../figures/belief";
import { Cell } from "../figures/cell/Cell";
import { stillness } from "../figures/picture/pulse";
import { beamModel, INITIAL } from "../figures/profile/model";
import { Profile } from "../figures/profile/Profile";
import { tellingReading } from "../figures/profile/reading";
import type { Store } from "../state";
import { Button } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { SiteHeader } from "../ui/SiteHeader";
import { Toasts, toast } from "../ui/Toast";
import { Contents } from "./lecture/Contents";
import { worldSession } from "./worldSession";

/** The visitor's own live world; null until the server has given one. */
const connection = signal<Connection | null>(null);
const session = signal<string | null>(null);
const trouble = signal<string | null>(null);

async function begin(): Promise<void> {
  try {
    const id = await worldSession();
    trouble.value = null;
    connection.peek()?.stop();
    const fresh = connect(id);
    fresh.start();
    session.value = id;
    connection.value = fresh;
  } catch (error) {
    trouble.value =
      error instanceof TypeError ? "The server does not answer; this page goes on trying." : (error as Error).message;
    setTimeout(() => void begin(), 3000);
  }
}

function Hero() {
  const live = connection.value;
  const store = live?.store;
  useSignalEffect(() => {
    if (connection.value?.status.value === "gone") void begin();
  });
  useSignalEffect(() => {
    const notice = connection.value?.store.notice.value;
    if (notice) toast(notice.message, notice.kind);
  });
  const lab = session.value ? `/lab.html?session=${encodeURIComponent(session.value)}` : "/lab.html";
  return (
    <section class="hero" aria-label="A live map">
      <div class="hero-map">
        {store && <Belief store={store} onTap={(point) => store.teleport(point)} />}
        <p class={`hero-hint${store?.teleported.value ? " used" : ""}`}>
          <Icon name="target" /> Click anywhere: the robot goes there
        </p>
      </div>
      <div class="hero-text">
        <h1>Watch a map bloom</h1>
        <p class="prose">
          A <b class="noun-robot">robot</b> walks through rooms that it has never seen. Each{" "}
          <b class="noun-beam">laser beam</b> is evidence: what it passes is probably <b class="noun-miss">free</b>,
          what it hits is probably <b class="noun-hit">occupied</b>. Cell by cell, the two add up to a map.
        </p>
        <div class="actions">
          <Button kind="primary" size="large" href={lab}>
            Open the lab
          </Button>
          <Button size="large" href="/logs.html">
            Map a robot’s log
          </Button>
        </div>
        <Facts />
        {stillness.value && store && <Steps store={store} />}
      </div>
    </section>
  );
}

/** Scans of one step: a second of the robot's walk. */
const STRIDE = 10;

/** The walk by steps, for who wants less motion. */
function Steps({ store }: { readonly store: Store }) {
  return (
    <div class="actions">
      <Button icon="stepForward" onClick={() => store.send({ type: "step", scans: STRIDE })}>
        {STRIDE} scans on
      </Button>
    </div>
  );
}

/** What the map knows so far, or what is the matter. */
function Facts() {
  const frame = connection.value?.store.frame.value;
  const status = connection.value?.status.value;
  if (trouble.value) return <p class="hero-facts">{trouble.value}</p>;
  if (status === "reconnecting")
    return <p class="hero-facts">The server does not answer; the map goes on when it does.</p>;
  if (!frame) return <p class="hero-facts" />;
  const readings = frame.index * frame.ranges.length;
  return (
    <p class="hero-facts">
      {frame.index.toLocaleString("en")} scans, {readings.toLocaleString("en")} readings so far
    </p>
  );
}

/** Until the session has said its parameters the figures show the table's first ones, and can be played with. */
const own = signal<Record<string, unknown>>({ ...INITIAL });
const parameters = computed(() => {
  const store = connection.value?.store;
  const values = store?.mapping.values.value ?? {};
  return Object.keys(values).length > 0 ? values : own.value;
});

function setParameter(name: string, value: number): void {
  const store = connection.peek()?.store;
  if (store?.hello.peek()) store.setParameter(name, value);
  else own.value = { ...own.peek(), [name]: value };
}

const reading = computed(() => {
  const store = connection.value?.store;
  return store && tellingReading(store);
});

/** What the clamp is for, with the increments of the moment. */
function Stubborn() {
  const { hit, miss } = beamModel({ ...INITIAL, ...parameters.value });
  const needed = miss < 0 ? Math.ceil((1000 * hit) / -miss).toLocaleString("en") : null;
  return (
    <>
      Without them, a cell that was hit 1,000 times{" "}
      {needed ? `would need ${needed} misses` : "could never be talked out of it,"}{" "}
      {needed ? "to forget it." : "whatever came."}
    </>
  );
}

function Page() {
  useEffect(() => {
    void begin();
  }, []);
  return (
    <>
      <Hero />
      <section class="home-section">
        <div class="prose">
          <h2>What one beam says</h2>
          <p>
            A reading of <b class="noun-beam">z</b> metres speaks about every cell along its beam. Those{" "}
            <b class="noun-miss">before z</b> let the light through. Those <b class="noun-hit">around z</b> sent it
            back. Of those <b class="noun-prior">beyond</b>, it knows nothing.
          </p>
          <p>
            This curve is the whole rule, and every part of it can be dragged. Make hits weaker, or the window wider,
            and the map above is made anew by your rule.
          </p>
        </div>
        <div class="figure-box">
          <Profile
            parameters={parameters}
            setParameter={setParameter}
            reading={reading}
            beamName={
              connection.value?.store.probe.value ? "the beam towards the pointer" : "a beam about straight ahead"
            }
          />
        </div>
      </section>
      <section class="home-section turned">
        <div class="prose">
          <h2>What one cell believes</h2>
          <p>
            Each cell keeps one number, the log-odds ℓ of being occupied. A <b class="noun-hit">hit</b> adds to it, a{" "}
            <b class="noun-miss">miss</b> takes away, and that is all: adding log-odds is multiplying odds, so the sum
            is Bayes’ rule.
          </p>
          <p>
            The dashed lines clamp it. <Stubborn /> With the clamp, a table that is carried away also leaves the map.
          </p>
        </div>
        <div class="figure-box small">
          <Cell parameters={parameters} />
        </div>
      </section>
      <section class="home-section">
        <div class="home-words">
          <div class="prose">
            <h2>All of it, step by step</h2>
            <p>
              From one cell to the file that a navigation stack reads: one page, a live figure in every section.
              Lecturers can show one figure at a time.
            </p>
          </div>
          <div class="actions">
            <Button kind="primary" size="large" href="/lecture.html">
              The whole lecture
            </Button>
            <Button size="large" href="/lecture.html?present">
              Present it
            </Button>
          </div>
        </div>
        <Contents page="/lecture.html" />
      </section>
      <section class="home-section">
        <div class="prose">
          <h2>Now your robot</h2>
          <p>
            Drop a log of a real robot and watch <em>its</em> map fill in. Then move a slider: the whole map is made
            again, from every reading, while your hand is still moving.
          </p>
        </div>
        <div class="actions">
          <Button kind="primary" size="large" icon="file" href="/logs.html">
            Choose a log
          </Button>
        </div>
      </section>
    </>
  );
}

render(
  <>
    <SiteHeader current="home" />
    <main>
      <Page />
    </main>
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
