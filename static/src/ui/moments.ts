/** Milliseconds after which the second file of a pair is of a new instant. */
const PAIR_MS = 600_000;

/**
 * Names of the instants of a map whose files are downloaded one after the other. Files that are asked for with the same
 * name are of the same map, and their file names end in it.
 */
export class Moments {
  private name = "";
  private begun = 0;
  private readonly taken = new Set<string>();

  /** Return the name for a file of a kind: that of the file of the other kind before it, else the time now. */
  next(kind: string, now: Date): string {
    if (this.name === "" || this.taken.has(kind) || now.getTime() - this.begun > PAIR_MS) {
      this.name = localTime(now);
      this.begun = now.getTime();
      this.taken.clear();
    }
    this.taken.add(kind);
    return this.name;
  }
}

/** Local time in letters that any file name takes: 2026-01-31_09-05-59. */
function localTime(time: Date): string {
  const two = (value: number): string => String(value).padStart(2, "0");
  const date = [time.getFullYear(), two(time.getMonth() + 1), two(time.getDate())].join("-");
  return `${date}_${[time.getHours(), time.getMinutes(), time.getSeconds()].map(two).join("-")}`;
}
