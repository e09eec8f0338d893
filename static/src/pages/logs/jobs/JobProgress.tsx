/** The progress of a job on a log, with the button that cancels it. */

import type { ComponentChildren } from "preact";
import { Button } from "../../../ui/Button";
import { ProgressBar } from "../../../ui/ProgressBar";
import type { JobStatus, LogJob } from "./LogJob";

interface JobProgressProps<S extends JobStatus> {
  readonly of: LogJob<S>;
  /** Name of the progress bar. */
  readonly label: string;
  /** The present step of a running job. */
  readonly stage: (job: S) => string;
  /** Results so far. */
  readonly figures?: (job: S) => ComponentChildren;
}

const waiting = (ahead: number): string =>
  `Waiting${ahead > 0 ? ` for ${ahead} other ${ahead === 1 ? "job" : "jobs"}` : ""}`;

/** Nothing if there is no running job. */
export function JobProgress<S extends JobStatus>({ of, label, stage, figures }: JobProgressProps<S>) {
  const job = of.job.value;
  if (!job || !of.isUnderWay.value) return null;
  const facts = figures?.(job);
  return (
    <div class="job-progress">
      <ProgressBar fraction={job.fraction} label={label} />
      <p role="status">{job.state === "queued" ? waiting(job.ahead) : stage(job)} …</p>
      <p class="quiet">
        {Math.floor(100 * job.fraction)} %{facts && <> · {facts}</>}
        {job.elapsed_s !== null && ` · ${Math.floor(job.elapsed_s)} s`}
      </p>
      <div class="actions">
        <Button icon="close" disabled={of.isBusy.value} onClick={() => void of.cancel()}>
          Cancel
        </Button>
      </div>
    </div>
  );
}
