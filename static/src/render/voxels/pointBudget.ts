/**
 * How many points of clouds are drawn: in a frame as many as are drawn quickly, by the time that frames have taken. While
 * the camera and the clip boxes rest, each frame adds the next ones to the picture, until all are in it. Clouds are in random order, so
 * that the first of their points are a sample of all.
 */

/** A frame is to take this long while the camera moves, ms. */
const TARGET_MS = 50;
/** The factor by which a frame may take longer while the camera rests. */
const AT_REST = 4;
/** The camera rests if it has not moved for this long, ms. */
const REST_MS = 300;
const FIRST = 250_000;
const LEAST = 20_000;
/** By how much the number changes from one frame to the next, at most. */
const [LESS, MORE] = [0.4, 1.25];

/** Some points of a cloud: the number of the first one, and how many. */
interface Slice {
  readonly first: number;
  readonly count: number;
}

/** All times are those of animation frames, ms. */
export class PointBudget {
  #budget = FIRST;
  #isHeld = false;
  /** Whether the camera has moved since the present frame began: the next one shows that, however late it is. */
  #hasMoved = false;
  #movedAt = Number.NEGATIVE_INFINITY;
  #isMoving = false;
  #frame = Number.NEGATIVE_INFINITY;
  /** Points that the clouds have, of those that the present frame was asked for so far, and the whole frame before. */
  #asked = 0;
  #askedBefore = 0;
  /** What else the present frame was asked for so far, and the whole frame before, as a number. */
  #others = 0;
  #othersBefore = 0;
  /** Whether what is drawn has changed since the present frame began. */
  #hasChanged = false;
  /** The share of each cloud that is in the picture before the present frame, and after it. */
  #from = 0;
  #to = 1;

  /** The camera or a clip box has moved, or is about to in the next frame. */
  moved(): void {
    this.#hasMoved = true;
  }

  /** What is drawn has changed, or is about to. */
  changed(): void {
    this.#hasChanged = true;
  }

  /** Whether a button or a finger holds the camera. */
  hold(isHeld: boolean): void {
    this.#isHeld = isHeld;
    if (!isHeld) this.moved();
  }

  /** Whether a frame only adds points to the picture: it is not cleared, and all else stays in it. */
  adds(frame: number): boolean {
    if (frame !== this.#frame) this.#begin(frame);
    return this.#from > 0;
  }

  /** Whether further frames would add points. */
  get lacks(): boolean {
    return this.#to < 1 && !this.#isHeld;
  }

  /** Something else than a cloud, of `count` vertices, is drawn in the frame: other such things are another picture. */
  note(count: number, frame: number): void {
    if (frame !== this.#frame) this.#begin(frame);
    this.#others = (31 * this.#others + count) | 0;
  }

  /** Which points of a cloud of `count` to draw. */
  take(count: number, frame: number): Slice {
    if (frame !== this.#frame) this.#begin(frame);
    this.#asked += count;
    const most = this.#isMoving ? this.#budget : AT_REST * this.#budget;
    this.#to = Math.min(1, this.#from + most / Math.max(this.#asked, this.#askedBefore));
    const first = Math.floor(count * this.#from);
    return { first, count: Math.floor(count * this.#to) - first };
  }

  #begin(frame: number): void {
    const took = frame - this.#frame;
    const isNext = this.#hasMoved && this.#movedAt === this.#frame; // else there was a pause between both
    if (this.#isMoving && isNext) {
      const budget = this.#budget * Math.min(MORE, Math.max(LESS, TARGET_MS / took));
      // No more than there are: the budget would grow without end while all are drawn.
      this.#budget = Math.max(LEAST, Math.min(budget, Math.max(this.#asked, FIRST)));
    }
    if (this.#hasMoved) this.#movedAt = frame;
    this.#isMoving = this.#isHeld || frame - this.#movedAt < REST_MS;
    const isSame =
      !this.#hasChanged && this.#asked === this.#askedBefore && this.#others === this.#othersBefore && this.#asked > 0;
    // What fits into one frame is drawn again in each.
    this.#from = isSame && !this.#isMoving && (this.#from > 0 || this.#to < 1) ? this.#to : 0;
    this.#hasMoved = this.#hasChanged = false;
    [this.#askedBefore, this.#othersBefore] = [this.#asked, this.#others];
    this.#asked = this.#others = 0;
    this.#frame = frame;
  }
}
