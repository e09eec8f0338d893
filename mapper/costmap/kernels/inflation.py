"""Exact distances to the nearest obstacle within a radius, and the costs of inflation.

Numba twins of :func:`mapper.costmap.textbook.squared_distances` and :func:`mapper.costmap.textbook.inflate`.

The distance is separable: for a cell it is the minimum, over the columns within the radius, of dx² + (distance to the
nearest obstacle of that column)². Distances within a column are computed in two passes over the rows. Source:
Felzenszwalb & Huttenlocher, Distance Transforms of Sampled Functions, 2012, section 2; here by direct comparison,
because the radius is small and slices of rows are vectorised.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, UInt8Array
from mapper.core.jit import jit

Squares = NDArray[np.unsignedinteger[Any]]  #: uint16 for radii of at most 180 cells, else uint32

TILE_ROWS, TILE_COLS = 64, 256
LETHAL, INSCRIBED, NO_INFORMATION = np.uint8(254), np.uint8(253), np.uint8(255)


@jit
def mark_blocks(costs: UInt8Array, with_unknown: bool, out: BoolArray) -> None:
    """Write which blocks (rows / 64, cols / 64), rounded up, contain an obstacle."""
    rows, cols = costs.shape
    for block_row in range(out.shape[0]):
        for block_col in range(out.shape[1]):
            left, right = block_col * 64, min(block_col * 64 + 64, cols)
            is_found = False
            for row in range(block_row * 64, min(block_row * 64 + 64, rows)):
                line = costs[row, left:right]
                count = 0
                for k in range(line.shape[0]):
                    count += (line[k] == LETHAL) | (with_unknown & (line[k] == NO_INFORMATION))
                if count > 0:
                    is_found = True
                    break
            out[block_row, block_col] = is_found


@jit
def near_blocks(blocks: BoolArray, row0: int, row1: int, col0: int, col1: int) -> bool:
    """Return whether any block that overlaps the box [row0, row1) × [col0, col1) is marked."""
    for row in range(max(row0, 0) // 64, min((row1 + 63) // 64, blocks.shape[0])):
        for col in range(max(col0, 0) // 64, min((col1 + 63) // 64, blocks.shape[1])):
            if blocks[row, col]:
                return True
    return False


@jit
def _column_distances(
    costs: UInt8Array, with_unknown: bool, radius: int, top: int, left: int, columns: UInt8Array
) -> None:
    """Write the distance (rows, cols) of each cell to the nearest obstacle of its column, at most ``radius`` + 1.

    Cell (0, 0) of ``columns`` is cell (top, left) of ``costs``; cells outside ``costs`` have no obstacle.
    """
    rows, cols = columns.shape
    far = np.uint8(radius + 1)
    first = max(-left, 0)
    last = min(costs.shape[1] - left, cols)
    for r in range(rows):
        line = columns[r]
        row = top + r
        if row < 0 or row >= costs.shape[0]:
            line[:] = far
        else:
            line[:first] = far
            line[last:] = far
            source, inner = costs[row, left + first : left + last], line[first:last]
            if with_unknown:
                for k in range(inner.shape[0]):
                    inner[k] = np.uint8(0) if source[k] >= LETHAL else far
            else:
                for k in range(inner.shape[0]):
                    inner[k] = np.uint8(0) if source[k] == LETHAL else far
        if r > 0:
            above = columns[r - 1]
            for k in range(cols):
                one_more = np.uint8(above[k] + np.uint8(1))
                line[k] = min(line[k], one_more)
    for r in range(rows - 2, -1, -1):
        line, below = columns[r], columns[r + 1]
        for k in range(cols):
            one_more = np.uint8(below[k] + np.uint8(1))
            line[k] = min(line[k], one_more)


@jit
def tile_distances(
    costs: UInt8Array, with_unknown: bool, radius: int, row0: int, col0: int, columns: UInt8Array, squares: Squares,
    out: Squares,
) -> None:  # fmt: skip
    """Write the squared distances (rows, cols), in cells, of the tile with its cell (0, 0) at (row0, col0) of
    ``costs``.

    Distances beyond ``radius`` are radius² + 1. ``columns`` (rows + 2 radius, cols + 2 radius) uint8 and ``squares``
    (cols + 2 radius,) are working memory; ``squares`` and ``out`` have the same unsigned integer type, which must hold
    2 (radius + 1)². ``radius`` is at most 253.
    """
    rows, cols = out.shape
    _column_distances(costs, with_unknown, radius, row0 - radius, col0 - radius, columns)
    kind = squares.dtype.type
    far = kind(radius * radius + 1)
    for r in range(rows):
        line, best = columns[r + radius], out[r]
        best[:] = far
        nearest = radius + 1
        for k in range(line.shape[0]):
            nearest = min(nearest, int(np.int64(line[k])))
        if nearest > radius:
            continue
        # Only columns within the radius of the first and the last obstacle near this row, and no horizontal offset too
        # long for the obstacle with the smallest distance along its column.
        first, last = 0, line.shape[0] - 1
        while line[first] > radius:
            first += 1
        while line[last] > radius:
            last -= 1
        reach = int(sqrt(radius * radius - nearest * nearest))
        begin, end = max(first - radius - reach, 0), min(last - radius + reach + 1, cols)
        if begin >= end:  # every obstacle near this row is too far from the tile horizontally
            continue
        for k in range(squares.shape[0]):
            squares[k] = kind(line[k]) * kind(line[k])
        near, centre = best[begin:end], squares[begin + radius : end + radius]
        for k in range(near.shape[0]):
            near[k] = min(near[k], centre[k])
        for dx in range(1, reach + 1):
            if dx & 3 == 1:
                greatest = kind(0)
                for k in range(near.shape[0]):
                    greatest = max(greatest, near[k])
                if dx * dx >= greatest:
                    break
            step = kind(dx * dx)
            before, after = squares[begin + radius - dx : end + radius - dx], squares[begin + radius + dx :]
            for k in range(near.shape[0]):
                nearer = kind(min(before[k], after[k]) + step)
                near[k] = min(near[k], nearer)


@jit
def write_costs(squared: Squares, table: UInt8Array, inflate_unknown: bool, costs: UInt8Array, out: UInt8Array) -> None:
    """Write the costs (rows, cols) of a tile: the greater of the old cost and that of the distance, as in Nav2.

    ``squared`` (rows, cols) are squared distances in cells, ``table`` the cost of each. A cell without information gets
    the cost of the distance if it is at least 253, or greater than 0 with ``inflate_unknown``.
    """
    rows, cols = out.shape
    least = np.uint8(1) if inflate_unknown else INSCRIBED
    for r in range(rows):
        line, old, new = squared[r], costs[r], out[r]
        for k in range(cols):
            cost = table[line[k]]
            before = old[k]
            new[k] = cost if (before == NO_INFORMATION) & (cost >= least) else max(before, cost)
