"""Smooth segments of the cells removed by the discs; those that continue smoothly into the ground are restored.

:func:`mapper.terrain.textbook_ground.given_back` is the same in plain NumPy.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray
from mapper.core.jit import jit

Heights = NDArray[np.float32]


@jit
def _root_of(parents: NDArray[np.int32], cell: int) -> int:
    """Return the first cell of a segment, with path compression."""
    while parents[cell] != cell:
        parents[cell] = parents[parents[cell]]
        cell = int(parents[cell])
    return cell


@jit
def _goes_on(
    heights: Heights, row: int, col: int, down: int, right: int, most: float, height: float, share: float
) -> bool:
    """Return whether the surface continues from a cell to the next: the rises before, between and after the two agree.

    ``most`` is the maximum rise between cells, metres; rises may differ by ``height`` + ``share`` · rise.
    """
    rows, cols = heights.shape
    before, left = row - down, col - right
    after, far = row + 2 * down, col + 2 * right
    if before < 0 or left < 0 or before >= rows or left >= cols:
        return False
    if after < 0 or far < 0 or after >= rows or far >= cols:
        return False
    first = heights[row, col] - heights[before, left]
    rise = heights[row + down, col + right] - heights[row, col]
    last = heights[after, far] - heights[row + down, col + right]
    steepest, base, factor = np.float32(most), np.float32(height), np.float32(share)
    return bool(
        abs(first) <= steepest
        and abs(last) <= steepest
        and abs(rise - first) <= base + factor * abs(first)
        and abs(rise - last) <= base + factor * abs(last)
    )


@jit
def join_cells(
    heights: Heights, taken: BoolArray, most: float, height: float, share: float, parents: NDArray[np.int32]
) -> None:
    """Join taken cells (rows, cols) into segments over which the surface is continuous; ``parents`` (rows · cols,)."""
    rows, cols = heights.shape
    for i in range(rows * cols):
        parents[i] = i
    for row in range(rows):
        for col in range(cols):
            if not taken[row, col]:
                continue
            for side in range(2):
                down, right = (0, 1) if side == 0 else (1, 0)
                y, x = row + down, col + right
                if y >= rows or x >= cols or not taken[y, x]:
                    continue
                if _goes_on(heights, row, col, down, right, most, height, share):
                    a, b = _root_of(parents, row * cols + col), _root_of(parents, y * cols + x)
                    parents[max(a, b)] = min(a, b)


@jit
def count_sides(
    heights: Heights,
    taken: BoolArray,
    most: float,
    height: float,
    share: float,
    parents: NDArray[np.int32],
    sides: NDArray[np.int32],
) -> None:
    """Write for each segment into ``sides`` (rows · cols, 4): sides into the ground, drops, and sums of directions.

    The directions, in rows and columns, are those of the sides into the ground.
    """
    rows, cols = heights.shape
    sides[:] = 0
    for row in range(rows):
        for col in range(cols):
            if not taken[row, col]:
                continue
            segment = _root_of(parents, row * cols + col)
            for side in range(4):
                down = 1 if side == 0 else (-1 if side == 1 else 0)
                right = 1 if side == 2 else (-1 if side == 3 else 0)
                y, x = row + down, col + right
                if y < 0 or x < 0 or y >= rows or x >= cols:
                    continue
                if taken[y, x] and _root_of(parents, y * cols + x) == segment:
                    continue
                if not taken[y, x] and _goes_on(heights, row, col, down, right, most, height, share):
                    sides[segment, 0] += np.int32(1)
                    sides[segment, 2] += np.int32(down)
                    sides[segment, 3] += np.int32(right)
                elif heights[row, col] > heights[y, x]:
                    sides[segment, 1] += np.int32(1)


@jit
def judge(
    taken: BoolArray,
    parents: NDArray[np.int32],
    sides: NDArray[np.int32],
    least_into: float,
    front: int,
    given: BoolArray,
    contested: BoolArray,
) -> None:
    """Write which taken cells are restored, and which are not although some of their sides continue into the ground."""
    rows, cols = taken.shape
    for row in range(rows):
        for col in range(cols):
            given[row, col] = contested[row, col] = False
            if taken[row, col]:
                segment = _root_of(parents, row * cols + col)
                into, drops = np.int64(sides[segment, 0]), np.int64(sides[segment, 1])
                down, right = np.int64(sides[segment, 2]), np.int64(sides[segment, 3])
                is_front = down * down + right * right >= front * front
                given[row, col] = into > 0 and (is_front or into >= least_into * (into + drops))
                contested[row, col] = into > 0 and not given[row, col]
