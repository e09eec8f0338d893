import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Picture } from "../../render/picture/Picture";
import { classroom } from "../../store/classroom";
import { followPages } from "../../tools/classroom/pages";
import { useOpenGroup } from "../../tools/why/useOpenGroup";
import { WhyGroup } from "../../tools/why/Why";
import { Dock, type DockGroup } from "../../ui/dock/Dock";
import { type Live, watchClassSession } from "../classSession";
import { exposeHook } from "../debugHook";
import { useClass } from "../useClass";
import { Compare } from "./compare/Compare";
import { useComparison } from "./compare/useComparison";
import { MapStage } from "./MapStage";
import { Settings } from "./Settings";
import { TrajectoryChoice } from "./trajectories/TrajectoryChoice";
import { ViewerFrame } from "./ViewerFrame";

const live = signal<Live | null>(null);

/** Follow the log pages of a class. Call it once. */
export function followLogs(): void {
  followPages("logs");
  watchClassSession("logs", (next) => {
    live.value = next;
  });
}

/** The page of a follower: the map of the log that the lecturer shows, or the follower's own copy. */
export function ClassLog() {
  const session = live.value;
  if (!session) {
    return (
      <p class="viewer-message" role="status">
        Waiting for the map of the lecturer …
      </p>
    );
  }
  return <SessionOfClass key={session.id} session={session} />;
}

/** Groups of a following page. Their ids differ from those of the lecturer's page, so that the open one stays. */
const FOLLOWED = ["settings", "why"];

function SessionOfClass({ session }: { readonly session: Live }) {
  const { store, trouble, id } = session;
  const picture = useRef<Picture | null>(null);
  const comparison = useComparison(id, store);
  const openGroup = useOpenGroup(store, "settings");
  const isFollowing = useClass(session, { page: "logs", group: openGroup, groups: FOLLOWED });
  useEffect(() => {
    exposeHook(session, () => picture.current);
    session.start();
    return () => session.stop();
  }, [session]);
  const isOwn = classroom.value?.own.value === id;
  const groups: readonly DockGroup[] = [
    { id: "settings", title: "Settings", keeps: true, content: () => <Settings store={store} sensor={null} /> },
    { id: "why", title: "Why", content: () => <WhyGroup store={store} /> },
  ];
  const own: readonly DockGroup[] = [
    { id: "poses", title: "Poses", content: () => <TrajectoryChoice store={store} /> },
    {
      id: "compare",
      title: "Compare",
      badge: comparison.isOn.value ? "on" : null,
      content: () => <Compare store={store} session={id} comparison={comparison} isGuest />,
    },
  ];
  return (
    <ViewerFrame
      class={isFollowing ? "is-following" : ""}
      dock={
        <Dock
          label="About this log"
          groups={isOwn ? [...groups, ...own] : groups}
          open={openGroup}
          isInert={isFollowing}
        />
      }
    >
      <header class="viewer-head">
        <h1>{store.hello.value?.title ?? "…"}</h1>
      </header>
      <MapStage
        store={store}
        comparison={comparison}
        trouble={trouble}
        isInert={isFollowing}
        onPicture={(made) => {
          picture.current = made;
        }}
      />
    </ViewerFrame>
  );
}
