/**
 * Reads a block of LZ4, the compression of the stream's tiles: copies of bytes, and no tables to be made for each tile.
 * Source: the LZ4 block format, https://github.com/lz4/lz4/blob/dev/doc/lz4_Block_format.md.
 */

const MIN_MATCH = 4;
const MORE = 15; // in four bits of a token: the length goes on in the bytes that follow
const LONG = 32; // literals from which it is worth to copy them by the browser's own means

/** Fill `out` with what a block holds. Throws RangeError for one that is broken or holds more or less than that. */
export function unpack(block: Uint8Array, out: Uint8Array): void {
  const end = block.length;
  let at = 0;
  let to = 0;

  const length = (start: number): number => {
    let total = start;
    if (start < MORE) return total;
    for (let more = 255; more === 255; total += more) {
      if (at >= end) throw new RangeError("The block ends within a length.");
      more = block[at++] as number;
    }
    return total;
  };

  while (at < end) {
    const token = block[at++] as number;
    const literals = length(token >> 4);
    if (literals > end - at || literals > out.length - to) throw new RangeError("Literals go beyond an end.");
    if (literals >= LONG) {
      out.set(block.subarray(at, at + literals), to);
      at += literals;
      to += literals;
    } else for (const stop = to + literals; to < stop; ) out[to++] = block[at++] as number;
    if (at === end) break; // the last sequence has literals only
    if (end - at < 2) throw new RangeError("The block ends within a match.");
    let from = to - ((block[at] as number) | ((block[at + 1] as number) << 8));
    at += 2;
    const matched = length(token & MORE) + MIN_MATCH;
    if (from < 0 || from === to || matched > out.length - to) throw new RangeError("A match goes beyond an end.");
    // Byte by byte: a match may overlap what it makes.
    for (const stop = to + matched; to < stop; ) out[to++] = out[from++] as number;
  }
  if (to !== out.length) throw new RangeError(`The block holds ${to} bytes, not ${out.length}.`);
}
