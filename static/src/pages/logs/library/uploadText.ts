/** How far an upload is, in words. */

import { bytes, clock } from "../../../ui/numbers";
import type { Upload } from "./uploading";

/** A rate is stated once it was measured for so long. */
const MEASURED_MS = 2000;

/** The bytes that are sent of all, the share, the rate and the time that is left, as far as they are known at `now`. */
export function uploadText({ bytes: all, sent, since }: Upload, now: number): string {
  if (since === null) return `waiting, ${bytes(all)}`;
  if (sent >= all) return `${bytes(all)} sent; the server stores them …`;
  const share = `${bytes(sent)} of ${bytes(all)}, ${Math.floor((100 * sent) / all)} %`;
  const elapsed = now - since.at;
  const rate = (1000 * (sent - since.sent)) / elapsed;
  if (elapsed < MEASURED_MS || rate <= 0) return share;
  return `${share}, ${bytes(rate)}/s, ${clock((all - sent) / rate)} left`;
}
