/** Merges the log with another one of the same place: both get poses in one frame, and their maps are shown as one. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import type { Comparison } from "../../../tools/compare/comparison";
import { Button } from "../../../ui/Button";
import { Panel } from "../../../ui/Panel";
import { ProgressBar } from "../../../ui/ProgressBar";
import { compareWith } from "../compare/sides";
import { type ChosenLog, LogChoice } from "../LogChoice";
import { cancelMerge, type MergeStatus, mergeState, mergeWith } from "./api";

interface MergeProps {
  readonly store: Store;
  readonly session: string;
  readonly comparison: Comparison;
}

const EVERY_MS = 500;

const STAGES: Readonly<Record<string, string>> = {
  "first log": "SLAM of this log",
  "second log": "SLAM of the other log",
  maps: "Searching one map in the other",
  loops: "Joining the scans of the two",
  refinement: "Refining all poses",
  writing: "Writing the log of both",
};

/** The page of the log of both. */
const pageOf = ({ log, topic }: NonNullable<MergeStatus["result"]>): string => {
  const query = new URLSearchParams({ log });
  if (topic !== null) query.set("topic", topic);
  return `/logs.html?${query}`;
};
const isUnderWay = (job: MergeStatus | null): boolean => job?.state === "queued" || job?.state === "running";

export function Merge({ store, session, comparison }: MergeProps) {
  const own = store.hello.value?.log?.id ?? "";
  const chosen = useSignal<ChosenLog | null>(null);
  const job = useSignal<MergeStatus | null>(null);
  const failure = useSignal<string | null>(null);
  const ask = async (what: Promise<MergeStatus>): Promise<void> => {
    failure.value = null;
    try {
      job.value = await what;
    } catch (error) {
      failure.value = error instanceof TypeError ? "The server does not answer." : (error as Error).message;
    }
  };
  const now = job.value;
  useEffect(() => {
    void mergeState(session).then(
      (found) => {
        job.value = found;
      },
      () => undefined, // the server does not answer: nothing is under way that this page knows of
    );
  }, [session, job]);
  useEffect(() => {
    if (!isUnderWay(now)) return;
    const timer = setTimeout(() => void ask(mergeState(session)), EVERY_MS);
    return () => clearTimeout(timer);
  });
  const showBoth = async (result: NonNullable<MergeStatus["result"]>): Promise<void> => {
    store.send({ type: "trajectory", name: result.trajectory });
    comparison.mode.value = "merge";
    failure.value = await compareWith(session, {
      log: now?.other ?? null,
      topic: chosen.peek()?.topic ?? null,
      trajectory: result.trajectory,
    });
  };
  return (
    <Panel title="Merge with another log">
      <div class="heal">
        <p class="quiet">
          Another log of the same place: SLAM corrects both, one map is laid on the other, and all scans are joined in
          one graph. The corrections of mount and clock in this map's parameters are used for both logs.
        </p>
        {!isUnderWay(now) && (
          <>
            <LogChoice
              own={own}
              chosen={chosen.value}
              disabled={false}
              onChoose={(choice) => {
                chosen.value = choice;
              }}
            />
            <div class="heal-actions">
              <Button
                disabled={chosen.value === null}
                onClick={() => chosen.value && void ask(mergeWith(session, chosen.value.log, chosen.value.topic))}
              >
                Merge the two logs
              </Button>
              {now?.result && (
                <Button onClick={() => now.result && void showBoth(now.result)}>Show both as one map</Button>
              )}
              {now?.result && (
                <a class="button" href={pageOf(now.result)}>
                  Open the log of both
                </a>
              )}
            </div>
          </>
        )}
        {now && isUnderWay(now) && (
          <div class="heal-progress">
            <ProgressBar fraction={now.fraction} label="Merging" />
            <p role="status">
              {now.state === "queued" ? "Waiting" : (STAGES[now.stage ?? ""] ?? "Preparing")} …{" "}
              {Math.floor(100 * now.fraction)} %{now.elapsed_s !== null && ` · ${Math.floor(now.elapsed_s)} s`}
            </p>
            <div class="heal-actions">
              <Button icon="close" onClick={() => void ask(cancelMerge(session))}>
                Cancel
              </Button>
            </div>
          </div>
        )}
        {now?.result && (
          <p role="status">
            Merged: {now.result.loops} of {now.result.tried} loops between the two logs fit. Both logs have a trajectory
            “merged” in one frame, and “{now.result.name}” has the scans of both: for its map, its files and its doctor.
            Its trajectory “SLAM” has the graph of both.
            {now.result.note && ` There ${now.result.note}.`}
          </p>
        )}
        {now?.state === "cancelled" && <p role="status">Merging was cancelled. Both logs are as before.</p>}
        {(failure.value ?? now?.error?.message) && (
          <p class="heal-failed" role="alert">
            {failure.value ?? now?.error?.message}
          </p>
        )}
      </div>
    </Panel>
  );
}
