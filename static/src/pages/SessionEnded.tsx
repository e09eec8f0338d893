import { Button } from "../ui/Button";

interface SessionEndedProps {
  /** What has ended. */
  readonly what?: string;
  /** What of it is still there, as a sentence. */
  readonly left: string;
  /** The text of the button that begins another session on the same. */
  readonly again: string;
  readonly onAgain: () => void;
  /** The text of the button that leads back. */
  readonly back: string;
  readonly onBack: (() => void) | undefined;
}

/** In place of a view whose session has ended on the server. */
export function SessionEnded({ what = "session", left, again, onAgain, back, onBack }: SessionEndedProps) {
  return (
    <div class="viewer-message" role="alert">
      <h1>This {what} has ended</h1>
      <p class="prose">Sessions end when they are idle, and when the server is started again. {left}</p>
      <div class="actions">
        <Button kind="primary" icon="restart" onClick={onAgain}>
          {again}
        </Button>
        {onBack && <Button onClick={onBack}>{back}</Button>}
      </div>
    </div>
  );
}
