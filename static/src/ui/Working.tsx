import { Button } from "./Button";

/** Progress of a computation on the server. */
export interface Work {
  readonly elapsed_s: number;
  /** 0 to 1; null where it is not known. */
  readonly fraction: number | null;
}

interface WorkingProps {
  /** Label of the computation. */
  readonly what: string;
  /** Null while there is no computation. */
  readonly work: Work | null;
  readonly onCancel?: (() => void) | undefined;
}

/** A note on a computation of the server with its progress, and a cancel button if it can be cancelled. */
export function Working({ what, work, onCancel }: WorkingProps) {
  return (
    <div class="working-place" role="status" aria-live="polite">
      {work && (
        <div class="working">
          <span>{what} …</span>
          {/* Hidden from screen readers, which would announce it four times a second. */}
          <span class="working-share" aria-hidden="true">
            {work.fraction === null ? `${Math.floor(work.elapsed_s)} s` : `${Math.floor(100 * work.fraction)} %`}
          </span>
          <div class={work.fraction === null ? "progress waiting" : "progress"} aria-hidden="true">
            <span style={work.fraction === null ? undefined : { transform: `scaleX(${work.fraction})` }} />
          </div>
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
