import { Button } from "../ui/Button";

interface NotOpenedProps {
  readonly title: string;
  readonly reason: string;
  /** Label of the button that opens the view again. */
  readonly again?: string;
  readonly onAgain: () => void;
  /** Label of the button that leads back. */
  readonly back?: string;
  readonly onBack?: (() => void) | undefined;
}

/** Shown instead of a view that could not be opened or has ended. */
export function NotOpened({ title, reason, again = "Try again", onAgain, back, onBack }: NotOpenedProps) {
  return (
    <div class="viewer-message" role="alert">
      <h1>{title}</h1>
      <p class="prose">{reason}</p>
      <div class="actions">
        <Button kind="primary" icon="restart" onClick={onAgain}>
          {again}
        </Button>
        {onBack && <Button onClick={onBack}>{back}</Button>}
      </div>
    </div>
  );
}

interface SessionEndedProps extends Omit<NotOpenedProps, "title" | "reason"> {
  /** What has ended. */
  readonly what?: string;
  /** A sentence on what is still available. */
  readonly left: string;
}

/** Shown instead of a view whose session has ended on the server. */
export function SessionEnded({ what = "session", left, ...buttons }: SessionEndedProps) {
  return (
    <NotOpened
      {...buttons}
      title={`This ${what} has ended`}
      reason={`Sessions end when they are idle, and when the server is started again. ${left}`}
    />
  );
}
