interface FailureProps {
  /** Nothing is shown without one. */
  readonly why: string | null | undefined;
  readonly class?: "failure";
}

/** Why what was asked for failed; a screen reader reads it at once. */
export const Failure = ({ why, ...look }: FailureProps) =>
  why ? (
    <p role="alert" {...look}>
      {why}
    </p>
  ) : null;
