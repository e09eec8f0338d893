import { Button } from "./Button";
import { clock } from "./numbers";
import { ProgressBar } from "./ProgressBar";

/** Progress of a computation on the server. */
export interface Work {
  readonly elapsed_s: number;
  /** 0 to 1; null where it is not known. */
  readonly fraction: number | null;
}

/** The share that is done, where it is known, and the time that it has taken. */
export const progressText = ({ fraction, elapsed_s }: Work): string =>
  `${fraction === null ? "" : `${Math.floor(100 * fraction)} %, `}${elapsed_s < 60 ? `${Math.floor(elapsed_s)} s` : clock(elapsed_s)}`;

interface WorkingProps {
  /** Label of the computation. */
  readonly what: string;
  /** Null while there is no computation. */
  readonly work: Work | null;
  readonly onCancel?: (() => void) | undefined;
  /** Whether it is shown over what contains it, which has to be positioned; otherwise in a corner of the page. */
  readonly isInside?: boolean;
}

/** A note on a computation of the server with its progress, and a cancel button if it can be cancelled. */
export function Working({ what, work, onCancel, isInside = false }: WorkingProps) {
  return (
    <div class={isInside ? "working-place inside" : "working-place"} role="status" aria-live="polite">
      {work && (
        <div class="working">
          <span>{what} …</span>
          {/* Hidden from screen readers, which would announce it four times a second. */}
          <span class="working-share" aria-hidden="true">
            {progressText(work)}
          </span>
          <ProgressBar fraction={work.fraction} />
          {onCancel && (
            <Button kind="quiet" onClick={onCancel}>
              Cancel
            </Button>
          )}
        </div>
      )}
    </div>
  );
}
