"""Visible faces of occupied voxels, merged into rectangles, for one chunk of 32³ voxels at a time.

Numba twins of :func:`mapper.volume.occupancy.textbook.chunk_colours` and
:func:`mapper.volume.occupancy.textbook.merged_faces`.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.types import Belief, FaceRule

CHUNK = 32  #: voxels along the side of a chunk
KEYS = 1 << 16
COVERED = 255  #: in place of a colour: a voxel that is not drawn, and hides the faces towards it


@jit
def fill_chunk(belief: Belief, x0: int, y0: int, z0: int, rule: FaceRule, out: UInt8Array) -> int:
    """Write the colours (34, 34, 34), z y x, of the voxels in and around a chunk; return the number of coloured voxels.

    ``x0``, ``y0``, ``z0`` are the key of the chunk's first voxel, multiples of 32; voxels around the chunk are not
    counted. The colour is 0 if a voxel is not occupied or not shown, and :data:`COVERED` if it is unknown and the rule
    draws only seen faces.
    """
    n = 0
    out[:] = 0
    if rule.seen_only:
        i0, i1 = max(0, rule.first[0] - x0 + 1), max(0, min(CHUNK + 2, rule.last[0] - x0 + 2))
        j0, j1 = max(0, rule.first[1] - y0 + 1), max(0, min(CHUNK + 2, rule.last[1] - y0 + 2))
        for k in range(max(0, rule.first[2] - z0 + 1), min(CHUNK + 2, rule.last[2] - z0 + 2)):
            out[k, j0:j1, i0:i1] = COVERED
    for bz in range(z0 - 8, z0 + CHUNK + 8, 8):
        for by in range(y0 - 8, y0 + CHUNK + 8, 8):
            for bx in range(x0 - 8, x0 + CHUNK + 8, 8):
                if min(bx, by, bz) < 0 or max(bx, by, bz) >= KEYS:
                    continue
                slot = slot_of(belief.table, block_code(bx, by, bz))
                if slot < 0 or (belief.maxima[slot] < rule.occupied and not rule.seen_only):
                    continue
                parts = belief.parts[slot]
                for z in range(max(0, z0 - 1 - bz), min(8, z0 + CHUNK + 1 - bz)):
                    key = bz + z
                    if key < rule.first[2] or key > rule.last[2]:
                        continue
                    height = 1 + min(max((key - rule.base) // rule.band, 0), rule.colours - 1)
                    for y in range(
                        max(0, y0 - 1 - by, rule.first[1] - by), min(8, y0 + CHUNK + 1 - by, rule.last[1] + 1 - by)
                    ):
                        line = belief.values[parts[z >> 1 << 2 | y >> 1], z & 1, y & 1]
                        for x in range(
                            max(0, x0 - 1 - bx, rule.first[0] - bx), min(8, x0 + CHUNK + 1 - bx, rule.last[0] + 1 - bx)
                        ):
                            value = line[x]
                            k, j, i = key - z0 + 1, by + y - y0 + 1, bx + x - x0 + 1
                            if not value >= rule.occupied:
                                if not np.isnan(value):
                                    out[k, j, i] = 0
                                continue
                            colour = height
                            if rule.by_belief:
                                share = (value - rule.occupied) / (rule.greatest - rule.occupied)
                                colour = 1 + min(max(int(share * rule.colours), 0), rule.colours - 1)
                            out[k, j, i] = colour
                            inside = min(i, j, k) > 0 and max(i, j, k) <= CHUNK
                            n += 1 if inside else 0
    return n


@jit
def merge_faces(colours: UInt8Array, mask: UInt8Array, out: UInt8Array) -> int:
    """Write the rectangles (n, 7) of the visible faces of a chunk's voxels; return n.

    ``colours`` (34, 34, 34), z y x, are those of :func:`fill_chunk`. A rectangle has the index of its side (−x, +x, −y,
    +y, −z, +z), the x, y and z of its first voxel in the chunk, its lengths in voxels along the two axes that follow
    its own (for x: y and z; for y: z and x; for z: x and y), and its colour. ``mask`` (32, 32) is scratch memory.
    ``out`` has room for n rectangles, at most 98,304; those beyond its length are counted but not written.
    """
    n = 0
    place = np.zeros(3, dtype=np.int64)
    for side in range(6):
        axis = side >> 1
        u, v = (axis + 1) % 3, (axis + 2) % 3
        step = 1 if side & 1 else -1
        for level in range(CHUNK):
            some = False
            for b in range(CHUNK):
                for a in range(CHUNK):
                    place[axis], place[u], place[v] = level + 1, a + 1, b + 1
                    colour = colours[place[2], place[1], place[0]]
                    if colour == COVERED:
                        colour = 0
                    if colour != 0:
                        place[axis] += step
                        if colours[place[2], place[1], place[0]] != 0:
                            colour = 0
                        else:
                            some = True
                    mask[b, a] = colour
            if not some:
                continue
            for b in range(CHUNK):
                a = 0
                while a < CHUNK:
                    colour = mask[b, a]
                    if colour == 0:
                        a += 1
                        continue
                    wide = 1
                    while a + wide < CHUNK and mask[b, a + wide] == colour:
                        wide += 1
                    high = 1
                    fits = True
                    while fits and b + high < CHUNK:
                        for k in range(a, a + wide):
                            if mask[b + high, k] != colour:
                                fits = False
                                break
                        if fits:
                            high += 1
                    for row in range(b, b + high):
                        for k in range(a, a + wide):
                            mask[row, k] = 0
                    if n < out.shape[0]:
                        place[axis], place[u], place[v] = level, a, b
                        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = side, place[0], place[1], place[2]
                        out[n, 4], out[n, 5], out[n, 6] = wide, high, colour
                    n += 1
                    a += wide
    return n
