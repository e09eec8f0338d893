/**
 * How many points of clouds are drawn while the camera moves: as many as are drawn quickly enough, by the time that
 * frames have taken. Once it rests, all are drawn. Clouds are in random order, so that the first of their points are a
 * sample of all.
 */

/** A frame is to take this long while the camera moves, ms. */
const TARGET_MS = 50;
/** The camera rests if it has not moved for this long, ms. */
const REST_MS = 300;
const FIRST = 400_000;
const LEAST = 20_000;
/** By how much the number changes from one frame to the next, at most. */
const [LESS, MORE] = [0.4, 1.25];

/** All times are those of animation frames, ms. */
export class PointBudget {
  #budget = FIRST;
  #movedAt = Number.NEGATIVE_INFINITY;
  #frame = Number.NEGATIVE_INFINITY;
  /** Points that the clouds have, of those that the present frame was asked for so far, and the whole frame before. */
  #asked = 0;
  #askedBefore = 0;
  /** Whether the present frame draws no more than the budget; its time says how many the next may draw. */
  #isLimited = false;

  /** The camera has moved, or is about to in this frame. */
  moved(frame: number): void {
    this.#movedAt = frame;
  }

  /** How many points of a cloud of `count` to draw. */
  take(count: number, frame: number): number {
    if (frame !== this.#frame) this.#begin(frame);
    this.#asked += count;
    this.#isLimited = this.#isMoving(frame);
    if (!this.#isLimited) return count;
    const all = Math.max(this.#asked, this.#askedBefore);
    return Math.min(count, Math.ceil((count * this.#budget) / all));
  }

  #isMoving(frame: number): boolean {
    return frame - this.#movedAt < REST_MS;
  }

  #begin(frame: number): void {
    const took = frame - this.#frame;
    if (this.#isLimited && this.#isMoving(frame)) {
      const wanted = this.#budget * Math.min(MORE, Math.max(LESS, TARGET_MS / took));
      // No more than there are: the budget would grow without end while all are drawn.
      this.#budget = Math.max(LEAST, Math.min(wanted, Math.max(this.#asked, FIRST)));
    }
    this.#askedBefore = this.#asked;
    this.#asked = 0;
    this.#frame = frame;
  }
}
