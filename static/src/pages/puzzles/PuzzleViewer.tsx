import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Picture } from "../../render/picture/Picture";
import { classroom } from "../../store/classroom";
import { useOpenGroup } from "../../tools/why/useOpenGroup";
import { WhyGroup } from "../../tools/why/Why";
import { Button } from "../../ui/Button";
import { toastFailure } from "../../ui/browser/attempts";
import { Dock, type DockGroup } from "../../ui/dock/Dock";
import type { Attempt, OfferedPuzzle } from "../../wire/http";
import { Compare } from "../logs/compare/Compare";
import { useComparison } from "../logs/compare/useComparison";
import { Doctor, findingsBadge, useDoctor } from "../logs/Doctor";
import { MapStage } from "../logs/MapStage";
import { Settings } from "../logs/Settings";
import { TrajectoryChoice } from "../logs/trajectories/TrajectoryChoice";
import { ViewerFrame } from "../logs/ViewerFrame";
import { SessionEnded } from "../SessionEnded";
import { useConnected } from "../useConnected";
import { leadsToCase, percent, progressText } from "./attempt";
import { CaseGroup } from "./CaseGroup";
import { attemptOf, step } from "./puzzles";

interface PuzzleViewerProps {
  readonly session: string;
  /** Back to the list; null if there is none. */
  readonly onClose: (() => void) | undefined;
  /** The session has ended on the server. */
  readonly onGone: () => void;
  readonly onSolved: (points: number) => void;
  /** An unsolved puzzle; null for none. */
  readonly next: OfferedPuzzle | null;
  readonly onNext: (name: string) => void;
}

/** The view of one puzzle: its map, the task, and the tools of the log page that find and repair its fault. */
export function PuzzleViewer({ session, onClose, onGone, onSolved, next, onNext }: PuzzleViewerProps) {
  const attempt = useSignal<Attempt | null>(null);
  const picture = useRef<Picture | null>(null);
  const connection = useConnected(session, { picture, title: attempt.value?.title ?? "Puzzle" });
  const { store, status, trouble } = connection;
  const comparison = useComparison(session, store);
  const doctor = useDoctor(store, session, true);
  const openGroup = useOpenGroup(store, "case");
  const isChecking = useSignal(false);
  const load = (): Promise<void> =>
    toastFailure(async () => {
      attempt.value = await attemptOf(session);
    });
  useEffect(() => void load(), [session]);
  // The map of all scans fills the picture: a grid of large cells is mostly a border.
  useSignalEffect(() => {
    void store.mapVersion.value;
    const frame = store.frame.peek();
    if (frame?.count && (frame.index ?? 0) >= frame.count) store.fitObserved();
  });
  const isSolved = attempt.value?.is_solved ?? false;
  useEffect(() => {
    if (isSolved) onSolved(attempt.peek()?.points ?? 0);
  }, [isSolved]);
  const check = async (): Promise<void> => {
    isChecking.value = true;
    await toastFailure(async () => {
      const checked = await step(session, "check");
      attempt.value = checked;
      if (leadsToCase(checked)) openGroup.value = "case";
    });
    isChecking.value = false;
  };
  // The attempt ends with its class, whose puzzle cannot be started again.
  const isOver = (classroom.value?.isFollowed && classroom.value.isOver.value) ?? false;
  useEffect(() => {
    if (isOver) connection.stop();
  }, [isOver, connection]);
  if (isOver) return <p class="viewer-message">The class has ended, and with it this attempt.</p>;
  if (status.value === "gone") {
    return (
      <SessionEnded
        what="attempt"
        left="You can start the puzzle again."
        again="Begin again"
        onAgain={onGone}
        back="All puzzles"
        onBack={onClose}
      />
    );
  }
  const now = attempt.value;
  const checkButton = now && !now.answer && (
    <Button disabled={isChecking.value} onClick={() => void check()}>
      {isChecking.value ? "Checking …" : "Check the map"}
    </Button>
  );
  // On a phone the head of the page is out of view while a value is changed.
  const checkBelow = checkButton && (
    <div class="case-check">
      {checkButton}
      <p role="status">{now.repair !== null && progressText(now)}</p>
    </div>
  );
  const groups: readonly DockGroup[] = [
    {
      id: "case",
      title: "Case",
      keeps: true,
      content: () => (
        <CaseGroup
          session={session}
          store={store}
          attempt={attempt}
          openGroup={openGroup}
          onCheck={() => void check()}
          isChecking={isChecking.value}
          onClose={onClose}
          next={next}
          onNext={onNext}
        />
      ),
    },
    {
      id: "settings",
      title: "Settings",
      keeps: true,
      content: () => (
        <>
          <Settings store={store} sensor={null} />
          {checkBelow}
        </>
      ),
    },
    {
      id: "poses",
      title: "Poses",
      content: () => (
        <>
          <TrajectoryChoice store={store} />
          {checkBelow}
        </>
      ),
    },
    { id: "why", title: "Why", content: () => <WhyGroup store={store} /> },
    {
      id: "compare",
      title: "Compare",
      badge: comparison.isOn.value ? "on" : null,
      content: () => <Compare store={store} session={session} comparison={comparison} isGuest />,
    },
    {
      id: "doctor",
      title: "Doctor",
      badge: findingsBadge(doctor),
      content: () => <Doctor store={store} doctor={doctor} />,
    },
  ];
  return (
    <ViewerFrame class="puzzle-viewer" dock={<Dock label="About this puzzle" groups={groups} open={openGroup} />}>
      <header class="viewer-head">
        {onClose && <Button kind="quiet" icon="back" label="All puzzles" onClick={onClose} />}
        <h1>{now?.title ?? "…"}</h1>
        {now && (
          <output class="case-score">
            <b class="number">{now.points}</b> of 100 points
          </output>
        )}
        {checkButton}
        {now && now.repair !== null && (
          <output class="viewer-badge">
            repaired {percent(now.repair)}
            {!now.answer && `, solved at ${percent(now.enough)}`}
          </output>
        )}
      </header>
      <MapStage
        store={store}
        comparison={comparison}
        trouble={trouble}
        onPicture={(made) => {
          picture.current = made;
        }}
      />
    </ViewerFrame>
  );
}
