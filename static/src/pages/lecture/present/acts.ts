import { classroom } from "../../../store/classroom";
import type { Act } from "./keys";
import { blank, endOf, goTo, isPreview, move, presenting, setPresenting, slides } from "./state";

/** Whether keys control the presentation at the moment. */
export const canAct = (): boolean =>
  presenting.peek() && !isPreview && !(classroom.peek()?.isFollowing.peek() ?? false);

const ACTS: Readonly<Record<Act, () => void>> = {
  next: () => move(1),
  back: () => move(-1),
  nextSlide: () => move(1, true),
  previousSlide: () => move(-1, true),
  first: () => goTo(endOf(slides.peek(), true)),
  last: () => goTo(endOf(slides.peek(), false)),
  blank: () => {
    blank.value = !blank.peek();
  },
  exit: () => {
    if (document.fullscreenElement) void document.exitFullscreen();
    setPresenting(false);
  },
  release: () => {},
};

/** Carry out the request of a key, a button or the speaker's window. */
export const act = (wanted: Act): void => ACTS[wanted]();
