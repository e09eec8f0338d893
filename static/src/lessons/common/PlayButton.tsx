import type { Signal } from "@preact/signals";
import { Button } from "../../ui/Button";
import { reducedMotion } from "../../ui/browser/media";

interface PlayButtonProps {
  readonly playing: Signal<boolean>;
  /** What it says while the figure stands still, and while it plays. */
  readonly play?: string;
  readonly pause?: string;
  /** Whether it shows its text, as the first button of a figure. */
  readonly isPrimary?: boolean;
  /** Called before each press takes effect: a figure at its end begins again. */
  readonly onPress?: () => void;
}

/** Plays a figure and pauses it; there is none where the system asks for reduced motion. */
export function PlayButton({ playing, play = "Play", pause = "Pause", isPrimary = false, onPress }: PlayButtonProps) {
  if (reducedMotion.value) return null;
  const text = playing.value ? pause : play;
  return (
    <Button
      kind={isPrimary ? "primary" : undefined}
      icon={playing.value ? "pause" : "play"}
      {...(isPrimary ? { children: text } : { label: text })}
      onClick={() => {
        onPress?.();
        playing.value = !playing.peek();
      }}
    />
  );
}
