/** Merges the log with another one of the same place: both get poses in one frame, and their maps are shown as one. */

import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Store } from "../../../store/store";
import type { Comparison } from "../../../tools/compare/comparison";
import { Button } from "../../../ui/Button";
import { Failure } from "../../../ui/Failure";
import { Panel } from "../../../ui/Panel";
import { compareWith } from "../compare/sides";
import { JobProgress } from "../jobs/JobProgress";
import { LogJob } from "../jobs/LogJob";
import { type ChosenLog, LogChoice } from "../LogChoice";
import { cancelMerge, type MergeStatus, mergeState, mergeWith } from "./api";

interface MergeProps {
  readonly store: Store;
  readonly session: string;
  readonly comparison: Comparison;
}

const STAGES: Readonly<Record<string, string>> = {
  "first log": "SLAM of this log",
  "second log": "SLAM of the other log",
  maps: "Searching one map in the other",
  loops: "Joining the scans of the two",
  refinement: "Refining all poses",
  writing: "Writing the log of both",
};

/** The page of the merged log. */
const pageOf = ({ log, topic }: NonNullable<MergeStatus["result"]>): string => {
  const query = new URLSearchParams({ log });
  if (topic !== null) query.set("topic", topic);
  return `/logs.html?${query}`;
};
export function Merge({ store, session, comparison }: MergeProps) {
  const own = store.hello.value?.log?.id ?? "";
  const chosen = useSignal<ChosenLog | null>(null);
  const merging = useMemo(
    () => new LogJob<MergeStatus>(store, session, { state: mergeState, cancel: cancelMerge }),
    [store, session],
  );
  useEffect(() => {
    merging.start();
    return () => merging.stop();
  }, [merging]);
  const now = merging.job.value;
  const begin = async (): Promise<void> => {
    const other = chosen.peek();
    if (other) await merging.follow(() => mergeWith(session, other.log, other.topic));
  };
  const showBoth = async (result: NonNullable<MergeStatus["result"]>): Promise<void> => {
    store.send({ type: "trajectory", name: result.trajectory });
    comparison.mode.value = "merge";
    merging.failure.value = await compareWith(session, {
      log: now?.other ?? null,
      topic: chosen.peek()?.topic ?? null,
      trajectory: result.trajectory,
    });
  };
  return (
    <Panel title="Merge with another log">
      <div class="panel-stack">
        <p class="quiet">
          Another log of the same place: SLAM corrects both, one map is laid on the other, and all scans are joined in
          one graph. The corrections of mount and clock in this map’s parameters are used for both logs.
        </p>
        {!merging.isUnderWay.value && (
          <>
            <LogChoice
              own={own}
              chosen={chosen.value}
              disabled={false}
              onChoose={(choice) => {
                chosen.value = choice;
              }}
            />
            <div class="actions">
              <Button disabled={chosen.value === null} onClick={() => void begin()}>
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
        <JobProgress of={merging} label="Merging" stage={(job) => STAGES[job.stage ?? ""] ?? "Preparing"} />
        {now?.result && (
          <p role="status">
            Merged: {now.result.loops} of {now.result.tried} loops between the two logs fit. Both logs have a trajectory
            “merged” in one frame, and “{now.result.name}” has the scans of both: for its map, its files and its doctor.
            Its trajectory “SLAM” has the graph of both.
            {now.result.note && ` There ${now.result.note}.`}
          </p>
        )}
        {now?.state === "cancelled" && <p role="status">Merging was cancelled. Both logs are as before.</p>}
        <Failure class="failure" why={merging.failure.value ?? now?.error?.message} />
      </div>
    </Panel>
  );
}
