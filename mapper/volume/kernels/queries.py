"""Map queries: the nearest occupied voxel, and the maximum log-odds of each column.

Numba twins of :func:`mapper.volume.occupancy.textbook.nearest_occupied` and
:func:`mapper.volume.occupancy.textbook.projection`.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int32Array, Int64Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.types import Belief

_BLOCKS = 8192  # along an axis


@jit
def _nearest_in_block(
    belief: Belief, slot: int, x0: int, y0: int, z0: int, at: Float64Array, occupied: float, best: float
) -> float:
    """Return the minimum squared distance, in voxels, from ``at`` (3,) to an occupied voxel of a block, or ``best``."""
    if belief.maxima[slot] < occupied:
        return best
    for z in range(8):
        dz = z0 + z + 0.5 - at[2]
        for y in range(8):
            dy = y0 + y + 0.5 - at[1]
            line = belief.values[belief.parts[slot, z >> 1 << 2 | y >> 1], z & 1, y & 1]
            for x in range(8):
                if line[x] >= occupied:
                    dx = x0 + x + 0.5 - at[0]
                    best = min(best, dx * dx + dy * dy + dz * dz)
    return best


@jit
def nearest_occupied(
    belief: Belief, corners: Int64Array, points: Float64Array, occupied: float, limit: float, out: Float64Array
) -> None:
    """Write the distance (n,) from each point (n, 3) to the nearest centre of an occupied voxel, infinite beyond a
    limit.

    Points and distances are in voxels; a point is a fractional key. ``corners`` (slots, 3) are the keys of the blocks'
    first voxels. Blocks are visited in growing cubes around the point, or all at once if the cube would have more
    blocks than the map.
    """
    for i in range(points.shape[0]):
        at = points[i]
        best = limit * limit * (1.0 + 1e-12)
        is_occupied = False
        bx, by, bz = int(np.floor(at[0] / 8.0)), int(np.floor(at[1] / 8.0)), int(np.floor(at[2] / 8.0))
        ring = 0
        while True:
            nearest = 8.0 * (ring - 1) + 0.5  # minimum distance of a voxel centre in the blocks of this ring
            if nearest > 0.0 and nearest * nearest > best:
                break
            if (2 * ring + 1) ** 3 > 8 * corners.shape[0] + 27:
                for slot in range(corners.shape[0]):
                    x0, y0, z0 = corners[slot, 0], corners[slot, 1], corners[slot, 2]
                    closer = _nearest_in_block(belief, slot, x0, y0, z0, at, occupied, best)
                    is_occupied |= closer < best
                    best = closer
                break
            for z in range(max(bz - ring, 0), min(bz + ring + 1, _BLOCKS)):
                for y in range(max(by - ring, 0), min(by + ring + 1, _BLOCKS)):
                    shell = abs(z - bz) == ring or abs(y - by) == ring
                    for x in range(bx - ring, bx + ring + 1, 1 if shell or ring == 0 else 2 * ring):
                        if x < 0 or x >= _BLOCKS:
                            continue
                        slot = slot_of(belief.table, block_code(8 * x, 8 * y, 8 * z))
                        if slot >= 0:
                            closer = _nearest_in_block(belief, slot, 8 * x, 8 * y, 8 * z, at, occupied, best)
                            is_occupied |= closer < best
                            best = closer
            ring += 1
        out[i] = sqrt(best) if is_occupied else np.inf


@jit
def project_columns(
    corners: Int64Array, parts: Int32Array, values: Float32Array, low: int, high: int, x0: int, y0: int,
    out: Float32Array,
) -> None:  # fmt: skip
    """Raise ``out`` (rows, cols) to the maximum log-odds of the voxels of each column with key z ``low`` … ``high``.

    ``corners`` (n, 3) and ``parts`` (n, 16) are those of blocks, with parts in ``values`` as in :class:`Belief`; cell
    (0, 0) is the column of key (``x0``, ``y0``). ``out`` is NaN where nothing is known yet.
    """
    for b in range(corners.shape[0]):
        for z in range(max(low - corners[b, 2], 0), min(high - corners[b, 2] + 1, 8)):
            for y in range(8):
                row = corners[b, 1] - y0 + y
                line = values[parts[b, z >> 1 << 2 | y >> 1], z & 1, y & 1]
                for x in range(8):
                    value = line[x]
                    if not np.isnan(value):
                        col = corners[b, 0] - x0 + x
                        old = out[row, col]
                        out[row, col] = value if np.isnan(old) else max(old, value)
