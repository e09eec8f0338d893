/** Two maps as one, in the bytes of the wire: ℓ = ℓ_a + ℓ_b − ℓ₀, as mapper/grid/merge.py adds them. */

import { logOddsAt, shownByteAt } from "../../grid/cellValues";
import type { Geometry } from "../../wire/protocol";
import type { Codes } from "./combinedMap";

type Range = Pick<Geometry, "low" | "high">;

/** For each pair of bytes the byte, in the range of b, of their sum; what only one map has observed stays what it is. */
export function mergedCodes(a: Range, b: Range, prior: number): Codes {
  const codes = new Uint8Array(65536);
  const byteOf = (logOdds: number): number => Math.round(shownByteAt(logOdds, b));
  for (let j = 1; j < 256; j++) codes[j] = j;
  for (let i = 1; i < 256; i++) {
    const valueA = logOddsAt(i, a);
    codes[i << 8] = byteOf(valueA);
    for (let j = 1; j < 256; j++) codes[(i << 8) | j] = byteOf(valueA + logOddsAt(j, b) - prior);
  }
  return codes;
}
