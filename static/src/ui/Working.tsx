import { Button } from "./Button";

/** How far a computation is on the server. */
export interface Work {
  readonly elapsed_s: number;
  /** 0 to 1; null where it is not known. */
  readonly fraction: number | null;
}

interface WorkingProps {
  /** What is being computed, as a person would say it. */
  readonly what: string;
  /** Null while nothing is. */
  readonly work: Work | null;
  readonly onCancel?: (() => void) | undefined;
}

/** A note over the page that the server computes, how far that is, and where it can be ended a button for that. */
export function Working({ what, work, onCancel }: WorkingProps) {
  return (
    <div class="working-place" role="status" aria-live="polite">
      {work && (
        <div class="working">
          <span>{what} …</span>
          {/* Said once, not four times a second. */}
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
