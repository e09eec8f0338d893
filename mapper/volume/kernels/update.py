"""Map update by the marks of one scan, and decay; each voxel is updated once.

Numba twins of :func:`mapper.volume.occupancy.textbook.insert_scan` and :func:`mapper.volume.occupancy.textbook.decay`.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array, UInt8Array, UInt16Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code
from mapper.volume.kernels.rays import ENDED
from mapper.volume.kernels.types import Belief, Box, Updates


@jit
def marked_blocks(
    words: Int64Array, box: Box, z0: int, z1: int, codes: Int64Array, corners: Int64Array, parts: UInt16Array
) -> int:
    """Write the codes (n,) of the blocks with marks and their offsets in the marks (n,); return n.

    Bits of ``parts`` (n,) are the parts of a block with marks. ``words`` are the marks of the box (nz, ny, nx) as words
    of eight; only layers of blocks ``z0`` … ``z1`` − 1 are processed.
    """
    row, n = box.nx // 8, 0
    for bz in range(z0, z1):
        for by in range(box.ny // 8):
            for bx in range(row):
                corner = (bz * 8 * box.ny + by * 8) * row + bx
                count = np.int64(0)
                for k in range(64):
                    count |= words[corner + ((k >> 3) * box.ny + (k & 7)) * row]
                if count != 0:
                    codes[n] = block_code(box.x + bx * 8, box.y + by * 8, box.z + bz * 8)
                    corners[n] = corner
                    some = 0
                    for k in range(64):
                        any_here = words[corner + ((k >> 3) * box.ny + (k & 7)) * row] != 0
                        some |= (1 if any_here else 0) << (k >> 4 << 2 | k >> 1 & 3)
                    parts[n] = some
                    n += 1
    return n


@jit
def add_parts(parts: Int32Array, slots: Int32Array, part_bits: UInt16Array, first: int) -> int:
    """Assign indices to the parts in the bits of ``part_bits`` (n,) that have none; return their number.

    The first new index is ``first``. ``parts`` (slots, 16) are the part indices of all blocks, 0 for none.
    """
    number = first
    for i in range(slots.shape[0]):
        for k in range(16):
            if part_bits[i] >> k & 1 and parts[slots[i], k] == 0:
                parts[slots[i], k] = number
                number += 1
    return number - first


@jit
def apply_marks(
    marks: UInt8Array, words: Int64Array, box: Box, corners: Int64Array, slots: Int32Array, updates: Updates,
    belief: Belief,
) -> None:  # fmt: skip
    """Add the updates to the log-odds of the marked voxels of blocks, clamp them, and clear the marks.

    ``marks`` and ``words`` are the same memory, as in :func:`marked_blocks`; the parts of blocks with marks must be
    allocated. The maximum log-odds and the number of known voxels are written for each block.
    """
    row = box.nx // 8
    zero = np.float32(0.0)
    miss, hit, least, greatest = updates.miss, updates.hit, updates.least, updates.greatest
    for i in range(slots.shape[0]):
        top, count = np.float32(-np.inf), 0
        for p in range(16):
            number = belief.parts[slots[i], p]
            if number == 0:
                continue
            part = belief.values[number].reshape(4, 8)
            for k in range(4):
                z, y = p >> 2 << 1 | k >> 1, (p & 3) << 1 | k & 1
                word = corners[i] + (z * box.ny + y) * row
                line, mark = part[k], marks[word * 8 : word * 8 + 8]
                for x in range(8):
                    old = line[x]
                    new = (zero if np.isnan(old) else old) + (hit if mark[x] == ENDED else miss)
                    new = min(max(new, least), greatest)
                    new = old if mark[x] == 0 else new
                    line[x] = new
                    unknown = np.isnan(new)
                    count += 0 if unknown else 1
                    top = top if unknown else max(top, new)
                words[word] = 0
        belief.maxima[slots[i]], belief.known[slots[i]] = top, count


@jit
def summarise_blocks(belief: Belief, n: int) -> None:
    """Write the maximum log-odds, −Inf without any, and the number of known voxels of the first ``n`` blocks."""
    for i in range(n):
        top, count = np.float32(-np.inf), 0
        for p in range(16):
            number = belief.parts[i, p]
            if number == 0:
                continue
            flat = belief.values[number].reshape(32)
            for k in range(32):
                value = flat[k]
                unknown = np.isnan(value)
                count += 0 if unknown else 1
                top = top if unknown else max(top, value)
        belief.maxima[i], belief.known[i] = top, count


@jit
def decay_blocks(values: Float32Array, factor: np.float32, forget_below: np.float32) -> None:
    """Multiply log-odds, of any shape, by ``factor``; those nearer to 0 than ``forget_below`` become unknown."""
    flat = values.reshape(-1)
    for k in range(flat.shape[0]):
        value = flat[k] * factor
        flat[k] = np.float32(np.nan) if abs(value) < forget_below else value
