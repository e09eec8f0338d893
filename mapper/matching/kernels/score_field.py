"""Score grid around points, for correlative matching: high in cells near a point, 0 far from all points.

Numba twins of :func:`mapper.matching.textbook.score_field` and :func:`mapper.matching.textbook.greatest_in_squares`.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.matching.kernels.types import NO_POINT, ScanArrays

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)


@jit
def add_scan(
    scores: UInt8Array, frame: Frame, stamps: UInt8Array, scans: ScanArrays, i: int, pose: Float64Array, stride: int
) -> int:
    """Raise ``scores`` (rows, cols) to at least the stamp of every ``stride``-th point of scan i at ``pose`` (3,).

    ``stamps`` (s, s, side, side) holds the scores around a point for each position of the point within its cell,
    rounded to 1/s of a cell: row, then column. Points and parts of stamps outside the grid are ignored. Returns the
    number of points inside.
    """
    rows, cols = scores.shape
    fine, side = stamps.shape[0], stamps.shape[2]
    reach = side // 2
    c, s = cos(pose[2]), sin(pose[2])
    inside = 0
    for k in range(0, scans.points.shape[1], stride):
        if scans.kind[i, k] == NO_POINT:
            continue
        p_x, p_y = np.float64(scans.points[i, k, 0]), np.float64(scans.points[i, k, 1])
        u, v = _to_lattice(pose[0] + c * p_x - s * p_y, pose[1] + s * p_x + c * p_y, frame)
        col_at, row_at = _cell_of(u), _cell_of(v)
        if not (0.0 <= row_at < rows and 0.0 <= col_at < cols):
            continue
        inside += 1
        row, col = int(row_at), int(col_at)
        stamp = stamps[int((v - row_at) * fine), int((u - col_at) * fine)]
        left, right = max(col - reach, 0), min(col + reach + 1, cols)
        for y in range(max(row - reach, 0), min(row + reach + 1, rows)):
            line, part = scores[y], stamp[y - row + reach]
            for x in range(left, right):
                value = part[x - col + reach]
                line[x] = max(line[x], value)
    return inside


@jit
def write_pyramid(scores: UInt8Array, levels: UInt8Array) -> None:
    """Write ``levels`` (n, rows, cols): at level l, the maximum score in the square of 2^l cells starting at each cell.

    The square extends to larger rows and columns, and ends at the grid's border. Level 0 is ``scores``. Source: Hess et
    al. 2016, section V-B, precomputed grids.
    """
    rows, cols = scores.shape
    levels[0] = scores
    higher = np.empty(cols, dtype=np.uint8)
    for level in range(1, levels.shape[0]):
        reach = min(1 << (level - 1), cols)
        below, here = levels[level - 1], levels[level]
        for row in range(rows):
            # Slices start at the first element read, so that the compiler sees plain loops over bytes.
            nearer, other, out = below[row], below[min(row + reach, rows - 1)], here[row]
            for col in range(cols):
                higher[col] = max(nearer[col], other[col])
            ahead = higher[reach:]
            for col in range(len(ahead)):
                out[col] = max(higher[col], ahead[col])
            for col in range(len(ahead), cols):  # the cells ahead are outside
                out[col] = higher[col]
