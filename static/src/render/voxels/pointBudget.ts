/**
 * How many points of clouds are drawn: while the camera moves as many as are drawn quickly, by the time that frames have
 * taken; once it rests, more: all of them, unless that takes long. Clouds are in random order, so that the first of
 * their points are a sample of all.
 */

/** A frame is to take this long while the camera moves, ms. */
const TARGET_MS = 50;
/** And at most so many times as long while it rests: viser's client draws each second, and waits for each frame. */
const AT_REST = 20;
/** The camera rests if it has not moved for this long, ms. */
const REST_MS = 300;
const FIRST = 250_000;
const LEAST = 20_000;
/** By how much the number changes from one frame to the next, at most. */
const [LESS, MORE] = [0.4, 1.25];

/** All times are those of animation frames, ms. */
export class PointBudget {
  #budget = FIRST;
  #isHeld = false;
  /** Whether the camera has moved since the present frame began: the next one shows that, however late it is. */
  #hasMoved = false;
  #movedAt = Number.NEGATIVE_INFINITY;
  #frame = Number.NEGATIVE_INFINITY;
  /** Points that the clouds have, of those that the present frame was asked for so far, and the whole frame before. */
  #asked = 0;
  #askedBefore = 0;
  /** Whether the present frame draws no more than the budget; its time says how many the next may draw. */
  #isLimited = false;

  /** The camera has moved, or is about to in the next frame. */
  moved(): void {
    this.#hasMoved = true;
  }

  /** Whether a button or a finger holds the camera. */
  hold(isHeld: boolean): void {
    this.#isHeld = isHeld;
    if (!isHeld) this.moved();
  }

  /** How many points of a cloud of `count` to draw. */
  take(count: number, frame: number): number {
    if (frame !== this.#frame) this.#begin(frame);
    this.#asked += count;
    this.#isLimited = this.#isMoving(frame);
    const all = Math.max(this.#asked, this.#askedBefore);
    const most = this.#isLimited ? this.#budget : AT_REST * this.#budget;
    return Math.min(count, Math.ceil((count * most) / all));
  }

  #isMoving(frame: number): boolean {
    return this.#isHeld || frame - this.#movedAt < REST_MS;
  }

  #begin(frame: number): void {
    const took = frame - this.#frame;
    const isNext = this.#hasMoved && this.#movedAt === this.#frame; // else there was a pause between both
    if (this.#hasMoved) this.#movedAt = frame;
    this.#hasMoved = false;
    if (this.#isLimited && isNext) {
      const wanted = this.#budget * Math.min(MORE, Math.max(LESS, TARGET_MS / took));
      // No more than there are: the budget would grow without end while all are drawn.
      this.#budget = Math.max(LEAST, Math.min(wanted, Math.max(this.#asked, FIRST)));
    }
    this.#askedBefore = this.#asked;
    this.#asked = 0;
    this.#frame = frame;
  }
}
