import "../style/index.css";
import "./home.css";
import { computed, signal, useSignalEffect } from "@preact/signals";
import { render } from "preact";
import { logOdds } from "../grid/cellValues";
import { beamModel, INITIAL_PARAMETERS } from "../grid/sensorModel";
import { Cell } from "../lessons/cell/Cell";
import type { Picture } from "../render/picture/Picture";
import { type Connection, connect } from "../store/connect";
import { firstPicture } from "../store/firstPicture";
import type { Store } from "../store/store";
import { ClassButton, ClassHost } from "../tools/classroom/ClassHost";
import { showOther } from "../tools/classroom/pages";
import { BeliefView } from "../tools/picture/BeliefView";
import { Plate } from "../tools/picture/Plate";
import { WorldView } from "../tools/picture/WorldView";
import { RobotAnnouncement } from "../tools/placing/Placing";
import { level, tableBounds } from "../tools/profile/handles";
import { ProfileFigure, useProfileView } from "../tools/profile/Profile";
import { profileReading } from "../tools/profile/reading";
import { Button } from "../ui/Button";
import { inHand, reducedMotion } from "../ui/browser/media";
import { Icon } from "../ui/Icon";
import { Slider } from "../ui/Slider";
import { SiteHeader } from "../ui/site/SiteHeader";
import { Toasts, toast } from "../ui/Toast";
import { whyAgain } from "../wire/ask";
import { FREE_THRESHOLD, LIVE_RANGE_MAX, LIVE_WINDOW } from "../wire/constants";
import { exposeHook } from "./debugHook";
import { LAB, LEGEND, LOGS, MORE, SENTENCE, TITLE } from "./firstScreen";
import { LECTURE_PARTS } from "./lecture/lessons";
import { Starting } from "./Starting";
import { shownStore } from "./shownStore";
import { hadWorld, worldSession } from "./worldSession";

/** The parts of the lecture, each a link to its first section. */
function Contents() {
  return (
    <nav class="contents" aria-label="Parts of the lecture">
      {LECTURE_PARTS.map(({ title, sentence, lessons }) => (
        <a key={title} href={`/lecture.html#${lessons[0]?.id}`}>
          <b>{title}</b>
          <span>{sentence}</span>
        </a>
      ))}
    </nav>
  );
}

/** The connection to the visitor's own live world; null until there is a session. */
const connection = signal<Connection | null>(null);
const session = signal<string | null>(null);
const trouble = signal<string | null>(null);
/** What the pictures and the curve show: a recording until the live world has a picture. */
const shown = shownStore(
  computed(() => connection.value?.store ?? null),
  hadWorld() ? null : firstPicture(),
);

const app = document.getElementById("app") as HTMLElement;
/**
 * The pictures of the world and the map that the page showed before this script ran; none for a world that continues.
 */
const htmlPictures = hadWorld() ? [] : [...app.querySelectorAll("picture")];

/** A picture of the HTML below the drawn one; without it the place would be empty until the first paint. */
function FirstPicture({ of }: { readonly of: Element | undefined }) {
  return <div class="first-picture" aria-hidden="true" ref={(place) => of && place?.append(of)} />;
}

/** The picture of the belief. */
let beliefPicture: Picture | null = null;
const onPicture = (picture: Picture): void => {
  beliefPicture = picture;
};

async function openWorld(): Promise<void> {
  try {
    const id = await worldSession();
    trouble.value = null;
    connection.peek()?.stop();
    const fresh = connect(id);
    exposeHook(fresh, () => beliefPicture);
    fresh.start();
    session.value = id;
    connection.value = fresh;
  } catch (error) {
    trouble.value = whyAgain(error);
    setTimeout(() => void openWorld(), 3000);
  }
}

function Hero() {
  const store = connection.value?.store ?? null;
  const pictured = shown.value;
  useSignalEffect(() => {
    if (connection.value?.status.value === "gone") void openWorld();
  });
  useSignalEffect(() => {
    const store = connection.value?.store;
    if (!store?.hello.value) return;
    for (const [name, value] of Object.entries(early.peek())) store.setParameter(name, value);
    early.value = {};
  });
  useSignalEffect(() => {
    const notice = connection.value?.store.notice.value;
    if (notice) toast(notice.message, notice.kind);
  });
  const lab = session.value ? `/lab.html?session=${encodeURIComponent(session.value)}` : LAB.href;
  return (
    <section class="hero" aria-label="A live map">
      <div class="hero-head">
        <h1>{TITLE}</h1>
        <div class="actions">
          <Button kind="primary" href={lab}>
            {LAB.label}
          </Button>
          <Button href={LOGS.href}>{LOGS.label}</Button>
          {reducedMotion.value && store && <Steps store={store} />}
        </div>
        <p>
          {SENTENCE.map((part) =>
            typeof part === "string" ? (
              part
            ) : (
              <b key={part.tone} class={`noun-${part.tone}`}>
                {part.text}
              </b>
            ),
          )}
        </p>
      </div>
      <div class="hero-maps">
        <Plate title="The world" note={inHand("click to teleport the robot")}>
          <FirstPicture of={htmlPictures[0]} />
          {pictured && <WorldView store={pictured} />}
        </Plate>
        <Plate title="The map" actions={<Legend />}>
          <FirstPicture of={htmlPictures[1]} />
          {pictured && (
            <BeliefView store={pictured} onTap={(point) => pictured.teleport(point)} onPicture={onPicture} />
          )}
        </Plate>
        {store && <RobotAnnouncement store={store} />}
        <Starting
          meanwhile="The sensor model can be dragged all the same."
          trouble={trouble.value ?? connection.value?.trouble.value ?? null}
        />
      </div>
      <Model />
      <Facts />
      <a class="hero-more" href={MORE.href}>
        <Icon name="unfold" /> {MORE.label}
      </a>
    </section>
  );
}

/** The colours of the map. */
function Legend() {
  return (
    <ul class="map-legend">
      {LEGEND.map(({ name, label, note }) => (
        <li key={name} class={name}>
          {label}
          {note && <span>{note}</span>}
        </li>
      ))}
    </ul>
  );
}

/** The reading that was set by hand, metres; null while the curve follows the beam. */
const handReading = signal<number | null>(null);

/** The inverse sensor model of the map: a curve whose parts can all be dragged, and its four numbers. */
function Model() {
  const view = useProfileView(parameters, reading, handReading);
  const isPointed = Boolean(shown.value?.probe.value);
  const { window, range_max } = view.values.value;
  const hit = level("hit", view.values.value, tableBounds);
  const miss = level("miss", view.values.value, tableBounds);
  return (
    <div class="hero-model">
      <div class="hero-curve">
        <ProfileFigure
          view={view}
          setParameter={setParameter}
          where={isPointed ? "towards the pointer" : "straight ahead"}
          fits
        />
      </div>
      <div class="hero-numbers">
        <Slider
          label="Range"
          sentence="The measured range z of the curve. It follows a beam of the robot until you set it."
          value={Math.min(view.z.value, range_max)}
          initial={Math.min(view.z.value, range_max)}
          low={0}
          high={range_max}
          step={0.01}
          unit="m"
          tone="beam"
          onInput={(value) => {
            handReading.value = value;
          }}
        />
        <Slider
          label="Window"
          sentence="Width w of the zone around the reading that counts as hit."
          value={window}
          initial={LIVE_WINDOW}
          {...tableBounds("window")}
          unit="m"
          tone="hit"
          onInput={(value) => setParameter("window", value)}
        />
        <Slider
          label="Hit"
          sentence="What a hit adds to the log-odds of a cell; in the step window, the probability of a cell that is hit."
          value={hit.value}
          initial={INITIAL_PARAMETERS[hit.name]}
          {...hit.range}
          tone="hit"
          onInput={(value) => setParameter(hit.name, value)}
        />
        <Slider
          label="Miss"
          sentence="What a miss adds to the log-odds of a cell; in the step window, the probability of a cell that is passed."
          value={miss.value}
          initial={INITIAL_PARAMETERS[miss.name]}
          {...miss.range}
          tone="miss"
          onInput={(value) => setParameter(miss.name, value)}
        />
      </div>
    </div>
  );
}

/** Scans per step: one second of simulated time. */
const SCANS_PER_STEP = 10;

/** A button that advances the simulation by one step, if reduced motion is preferred. */
function Steps({ store }: { readonly store: Store }) {
  return (
    <Button icon="stepForward" onClick={() => store.send({ type: "step", scans: SCANS_PER_STEP })}>
      Forward {SCANS_PER_STEP} scans
    </Button>
  );
}

/** Counts of scans and readings in the map. */
function Facts() {
  const frame = connection.value?.store.frame.value;
  if (!frame) return <p class="hero-facts" />;
  const readings = frame.index * frame.ranges.length;
  return (
    <p class="hero-facts">
      {frame.index.toLocaleString("en")} scans, {readings.toLocaleString("en")} readings so far
    </p>
  );
}

/** The parameters with which the session begins, for the figures until the session's own are known. */
const FIRST = { ...INITIAL_PARAMETERS, range_max: LIVE_RANGE_MAX, window: LIVE_WINDOW };
/** Changes made until then, which are sent to the session. */
const early = signal<Readonly<Record<string, number>>>({});
const parameters = computed(() => {
  const store = connection.value?.store;
  return store?.hello.value ? store.mapping.values.value : { ...FIRST, ...early.value };
});

function setParameter(name: string, value: number): void {
  const store = connection.peek()?.store;
  if (store?.hello.peek()) store.setParameter(name, value);
  else early.value = { ...early.peek(), [name]: value };
}

const reading = computed(() => {
  const store = shown.value;
  return store ? profileReading(store) : undefined;
});

/** A sentence on the effect of the clamp, with the current increments. */
function ClampEffect() {
  const { hit, miss } = beamModel({ ...INITIAL_PARAMETERS, ...parameters.value });
  const freeBelow = logOdds(FREE_THRESHOLD);
  const needed = miss < 0 ? Math.ceil((1000 * hit - freeBelow) / -miss).toLocaleString("en") : null;
  return (
    <>
      Without it, a cell that was hit 1,000 times{" "}
      {needed ? `would need ${needed} misses` : "would never become free again,"}{" "}
      {needed ? "to become free again." : "whatever is measured later."}
    </>
  );
}

/** Whether this browser has the cookie of the service's token, which pages cannot read. */
const SIGNED_IN = /(^|; )gridbloom_signed_in=1/.test(document.cookie);

function Page() {
  return (
    <>
      <Hero />
      <section class="home-section" id="cell">
        <div class="prose">
          <h2>What one cell believes</h2>
          <p>
            Each cell keeps one number, the log-odds ℓ of being occupied. A <b class="noun-hit">hit</b> adds to it, a{" "}
            <b class="noun-miss">miss</b> subtracts from it. Adding log-odds is multiplying odds, so the sum is Bayes’
            rule.
          </p>
          <p>
            The clamp keeps it between the dashed lines. <ClampEffect /> With the clamp, a table that is removed also
            disappears from the map.
          </p>
        </div>
        <div class="figure-box">
          <Cell parameters={parameters} />
        </div>
      </section>
      <section class="home-section">
        <div class="home-words">
          <div class="prose">
            <h2>The lecture, step by step</h2>
            <p>
              From one cell to the map file that a navigation stack reads: one page with an interactive figure in every
              section. In presentation mode it shows one figure at a time.
            </p>
          </div>
          <div class="actions">
            <Button kind="primary" size="large" href="/lecture.html">
              Open the lecture
            </Button>
            <Button size="large" href="/lecture.html?present">
              Presentation mode
            </Button>
          </div>
        </div>
        <Contents />
      </section>
      <section class="home-section">
        <div class="prose">
          <h2>Puzzles</h2>
          <p>
            Maps with a hidden fault: a sensor mounted askew, a clock that is late, people in the way. Find the cause,
            repair the map.
          </p>
        </div>
        <div class="actions">
          <Button kind="primary" size="large" href="/puzzles.html">
            Open the puzzles
          </Button>
        </div>
      </section>
      <section class="home-section">
        <div class="prose">
          <h2>Your robot’s log</h2>
          <p>
            Open a log of a real robot and watch its map fill in. Move a slider, and the whole map is computed again
            from every reading.
          </p>
        </div>
        <div class="actions">
          <Button kind="primary" size="large" icon="file" href="/logs.html">
            Choose a log
          </Button>
        </div>
      </section>
      {SIGNED_IN && (
        <p class="home-section quiet">
          This browser has signed in with the service’s token. <a href="/sign-out">Sign out</a>
        </p>
      )}
    </>
  );
}

void openWorld(); // before the first rendering: the server makes the world meanwhile
showOther();
app.replaceChildren(); // what the page showed until this script ran
render(
  <>
    <SiteHeader current="home">
      <ClassButton />
    </SiteHeader>
    <main id="main" tabIndex={-1}>
      <Page />
    </main>
    <ClassHost />
    <Toasts />
  </>,
  app,
);
