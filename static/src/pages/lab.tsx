import {
  computed,
  effect,
  type ReadonlySignal,
  type Signal,
  signal,
  untracked,
  useSignal,
  useSignalEffect,
} from "@preact/signals";
import { type RefObject, render } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Picture } from "../render/picture/Picture";
import { classroom, followedCode } from "../store/classroom";
import { connect } from "../store/connect";
import { firstPicture } from "../store/firstPicture";
import type { Store } from "../store/store";
import { ClassButton, ClassHost } from "../tools/classroom/ClassHost";
import { slidesAround, tellOfNote } from "../tools/classroom/pageInSlide";
import { followPages, loadingPage } from "../tools/classroom/pages";
import type { Comparison } from "../tools/compare/comparison";
import { useComparison } from "../tools/compare/SecondMap";
import { ProfileFigure, useProfileView } from "../tools/profile/Profile";
import { profileReading } from "../tools/profile/reading";
import { useOpenGroup } from "../tools/why/useOpenGroup";
import { watchVisibility } from "../ui/browser/whenIdle";
import { Dock } from "../ui/dock/Dock";
import { SiteHeader } from "../ui/site/SiteHeader";
import { LayoutChoice } from "../ui/stage/LayoutChoice";
import type { Layout } from "../ui/stage/layout";
import { Stage as Views } from "../ui/stage/Stage";
import { useLayout } from "../ui/stage/useLayout";
import { Toasts, toast } from "../ui/Toast";
import { Working } from "../ui/Working";
import { whyAgain } from "../wire/ask";
import { type Live, watchClassSession } from "./classSession";
import { exposeHook } from "./debugHook";
import { Connected, Controls } from "./lab/Controls";
import { groupsOf } from "./lab/groups";
import { groupFromAddress, namesNoWorld, visibleState } from "./lab/link";
import { keepAddress, openSession, restore } from "./lab/session";
import { KINDS, type LabPictures, lastLayout, PRESETS, viewsOf, WORLD_AND_MAP } from "./lab/views";
import { isDelayed, Starting } from "./Starting";
import { hasPicture, shownStore } from "./shownStore";
import { useClass } from "./useClass";
import { replay } from "./worldSession";
import "./lab/stage.css";
import "../style/index.css";
import "./lab/lab.css";

interface StageProps extends LabPictures {
  readonly layout: Signal<Layout>;
  /** Whether all its controls are disabled. */
  readonly isInert: boolean;
}

/** The stage of the lab: its views and the borders between them. */
function Stage({ layout, isInert, ...pictures }: StageProps) {
  const now = layout.value;
  return (
    <div class="lab-stage" inert={isInert}>
      <Views
        views={viewsOf(pictures)}
        layout={now}
        onLayout={(next) => {
          layout.value = next;
        }}
        isTogether={now.arrangement === "beside" && `${now.views}` === `${WORLD_AND_MAP.views}`}
      />
    </div>
  );
}

type Reading = number | null | undefined;

/** Rates at which the profile is updated for a pointed beam and for the default beam. */
const POINTED_MS = 100;
const IDLE_MS = 300;
/** If a smaller share of the profile is visible, it is not updated, which leaves the time to the pictures. */
const LEAST_SHARE = 0.35;

/**
 * The reading of the inspected beam for the profile, which is redrawn with each reading. Without graphics hardware that
 * takes longer than a frame of both pictures, so the profile is updated at a low rate and only while visible.
 */
function useReading(store: Store, place: RefObject<HTMLElement | null>): ReadonlySignal<Reading> {
  const reading = useMemo(() => signal<Reading>(undefined), []);
  useEffect(() => {
    const seen = signal(false);
    const onChange = ({ intersectionRatio }: IntersectionObserverEntry): void => {
      seen.value = intersectionRatio >= LEAST_SHARE;
    };
    const unwatch = place.current && watchVisibility(place.current, onChange, { threshold: [0, LEAST_SHARE] });
    let timer: ReturnType<typeof setTimeout> | undefined;
    let readAt = Number.NEGATIVE_INFINITY;
    const read = (): void => {
      timer = undefined;
      readAt = performance.now();
      reading.value = untracked(() => profileReading(store));
    };
    const stop = effect(() => {
      const beam = store.inspectedBeam.value;
      const pointed = store.probe.value !== null;
      if (!beam || (!pointed && !seen.value && reading.peek() !== undefined)) return;
      timer ??= setTimeout(read, Math.max(0, readAt + (pointed ? POINTED_MS : IDLE_MS) - performance.now()));
    });
    return () => {
      stop();
      unwatch?.();
      clearTimeout(timer);
    };
  }, [store, place, reading]);
  return reading;
}

/** The current session; null until the server has opened one. */
const live = signal<Live | null>(null);
const trouble = signal<string | null>(null);
const RETRY_MS = 3000;
/** Read before the address follows the session. */
const FIRST_GROUP = groupFromAddress();
/** What the pictures show: if the address names no session and no link, a recording until there is a map. */
const shown = shownStore(
  computed(() => live.value?.store ?? null),
  namesNoWorld() && followedCode === null ? firstPicture() : null,
);

async function connectLab(): Promise<void> {
  try {
    const before = live.peek();
    const { id, notice, shown } = await openSession(before?.store.playing.peek() === false);
    before?.stop();
    stopAddress();
    const connection = connect(id);
    let picture: Picture | null = null;
    onPicture = (made) => {
      picture = made;
    };
    exposeHook(connection, () => picture);
    connection.start();
    // Of a session that has ended the page knows more than its address, such as changes made while disconnected.
    if (shown) restore(connection.store, before ? visibleState(before.store) : shown);
    if (shown && before) connection.store.takeOver(before.store);
    stopAddress = keepAddress(id, connection.store);
    trouble.value = null;
    live.value = { ...connection, id };
    if (notice) toast(notice);
  } catch (error) {
    trouble.value = whyAgain(error);
    setTimeout(() => void connectLab(), RETRY_MS);
  }
}

let stopAddress: () => void = () => undefined;
let onPicture: (picture: Picture) => void = () => undefined;

/** The curve and the groups of controls. Both use the state of the profile. */
function Instruments({ session, comparison, layout, openGroup, isFollowing }: InstrumentsProps) {
  const { store, id } = session;
  const place = useRef<HTMLDivElement>(null);
  const reading = useReading(store, place);
  const isPointed = useMemo(() => computed(() => store.probe.value !== null), [store]);
  const set = useMemo(() => (name: string, value: number) => store.setParameter(name, value), [store]);
  const profile = useProfileView(store.mapping.values, reading);
  return (
    <>
      <section class="lab-curve" aria-label="Inverse sensor model" ref={place} inert={isFollowing}>
        <ProfileFigure
          view={profile}
          setParameter={set}
          where={isPointed.value ? "towards the pointer" : "straight ahead"}
          fits
        />
      </section>
      <Dock
        label="Controls of the lab"
        groups={groupsOf({ store, session: id, comparison, profile, layout })}
        open={openGroup}
        isInert={isFollowing}
      />
    </>
  );
}

interface InstrumentsProps {
  readonly session: Live;
  readonly comparison: Comparison;
  readonly layout: Signal<Layout> | null;
  /** The id of the open group. */
  readonly openGroup: Signal<string>;
  /** Whether the lecturer controls them. */
  readonly isFollowing: boolean;
}

function Lab() {
  const session = live.value;
  const store = session?.store ?? null;
  const comparison = useComparison(store);
  const openGroup = useOpenGroup(store, FIRST_GROUP);
  // The curve and the groups take longer to render and wait until the pictures show a map.
  const isSeen = useSignal(false);
  // The enclosing slide shows the page once it is complete.
  const isComplete = slidesAround === null || isSeen.value;
  const isFollowing = useClass(isComplete ? session : null, { page: "lab", group: openGroup });
  const isOwn = followedCode === null;
  const layout = useLayout({ kinds: KINDS, usual: WORLD_AND_MAP, last: isOwn ? lastLayout : null });
  const title = isFollowing ? classroom.value?.shown.value?.view.slide?.title : null;
  useSignalEffect(() => {
    const store = live.value?.store;
    if (isSeen.peek() || !store || !hasPicture(store)) return;
    requestAnimationFrame(() =>
      setTimeout(() => {
        isSeen.value = true;
      }),
    );
  });
  useSignalEffect(() => {
    if (isDelayed.value || trouble.value || replay.value || live.value?.trouble.value) tellOfNote();
  });
  const isAwaited = isFollowing && !isSeen.value;
  useEffect(() => {
    loadingPage.value = isAwaited ? "lab" : null;
  }, [isAwaited]);
  useSignalEffect(() => {
    if (live.value?.status.value !== "gone" || followedCode !== null) return;
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
    <main class={`lab ${isFollowing ? "is-following" : ""}`} id="main" tabIndex={-1}>
      <div class="lab-bar">
        <h1 class={title ? "lab-title" : "visually-hidden"}>{title ?? "The lab"}</h1>
        <Controls store={store} />
        {isOwn && <LayoutChoice layout={layout} kinds={KINDS} presets={PRESETS} />}
        {!(followedCode !== null && classroom.value?.isOver.value) && <Connected connection={session} />}
      </div>
      {trouble.value && (
        <p class="lab-trouble" role="alert">
          {trouble.value}
        </p>
      )}
      {replay.value && <Working what="Replaying the link" work={replay.value.work} onCancel={replay.value.cancel} />}
      <Starting />
      <Stage
        session={session}
        shown={shown.value}
        comparison={comparison}
        layout={layout}
        isInert={isFollowing && !classroom.value?.drives.value}
        onPicture={(picture) => onPicture(picture)}
      />
      {isSeen.value && session && comparison ? (
        <Instruments
          session={session}
          comparison={comparison}
          layout={isOwn ? layout : null}
          openGroup={openGroup}
          isFollowing={isFollowing}
        />
      ) : (
        <>
          <div class="lab-curve ghost" aria-busy="true" />
          <div class="dock ghost" aria-busy="true" />
        </>
      )}
    </main>
  );
}

if (followedCode === null) void connectLab();
else {
  followPages("lab");
  watchClassSession("lab", (next) => {
    live.peek()?.stop();
    if (next) {
      exposeHook(next, () => null);
      next.start();
    }
    live.value = next;
  });
}
render(
  <>
    <SiteHeader current="lab" links={followedCode === null}>
      <ClassButton />
    </SiteHeader>
    <Lab />
    <ClassHost />
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
