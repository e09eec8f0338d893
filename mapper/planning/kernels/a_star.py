"""A* with a binary heap that contains each cell at most once."""

from __future__ import annotations

from math import inf

import numpy as np

from mapper.core.array_types import Float64Array, Int32Array, UInt8Array
from mapper.core.jit import jit
from mapper.planning.kernels.steps import D_COL, D_ROW, DIAGONAL, _is_open

NOT_WAITING, EXPANDED = -1, -2


@jit
def _sift_up(keys: Float64Array, cells: Int32Array, slots: Int32Array, k: int, key: float, cell: int) -> None:
    """Insert a cell at slot ``k`` of the heap or above; cells are ordered by key, then by index."""
    while k > 0:
        up = (k - 1) // 2
        if keys[up] < key or (keys[up] == key and cells[up] <= cell):
            break
        keys[k], cells[k] = keys[up], cells[up]
        slots[cells[k]] = k
        k = up
    keys[k], cells[k], slots[cell] = key, cell, k


@jit
def _drop_first(keys: Float64Array, cells: Int32Array, slots: Int32Array, n: int) -> None:
    """Remove the first of the ``n`` cells from the heap."""
    key, cell = keys[n - 1], cells[n - 1]
    k = 0
    while 2 * k + 1 < n - 1:
        low = 2 * k + 1
        other = low + 1
        if other < n - 1 and (keys[other] < keys[low] or (keys[other] == keys[low] and cells[other] < cells[low])):
            low = other
        if key < keys[low] or (key == keys[low] and cell <= cells[low]):
            break
        keys[k], cells[k] = keys[low], cells[low]
        slots[cells[k]] = k
        k = low
    keys[k], cells[k], slots[cell] = key, cell, k


@jit
def search(
    costs: UInt8Array,
    table: Float64Array,
    start: int,
    goal: int,
    least: float,
    keys: Float64Array,
    cells: Int32Array,
    slots: Int32Array,
    out: Float64Array,
) -> None:
    """Write the cost-to-come (rows, cols) of the cells expanded by A*; infinity elsewhere.

    Numba twin of :func:`mapper.planning.textbook.a_star`. Cells are row · cols + col. ``least`` is the cheapest step;
    ``keys``, ``cells`` and ``slots`` (rows · cols,) are working memory.
    """
    cols = costs.shape[1]
    goal_row, goal_col = goal // cols, goal % cols
    out[:] = inf
    slots[:] = NOT_WAITING
    out[start // cols, start % cols] = 0.0
    keys[0], cells[0], slots[start] = 0.0, start, 0
    n = 1
    while n > 0:
        cell = np.int64(cells[0])
        _drop_first(keys, cells, slots, n)
        n -= 1
        slots[cell] = EXPANDED
        if cell == goal:
            break
        row, col = cell // cols, cell % cols
        for k in range(8):
            if not _is_open(costs, table, row, col, k):
                continue
            to_row, to_col = row + D_ROW[k], col + D_COL[k]
            to = to_row * cols + to_col
            step = table[costs[to_row, to_col]]
            new = out[row, col] + (step if k < 4 else step * DIAGONAL)
            if slots[to] == EXPANDED or not new < out[to_row, to_col]:
                continue
            out[to_row, to_col] = new
            d_row, d_col = abs(to_row - goal_row), abs(to_col - goal_col)
            to_go = least * (max(d_row, d_col) + (DIAGONAL - 1.0) * min(d_row, d_col))
            if slots[to] == NOT_WAITING:
                _sift_up(keys, cells, slots, n, new + to_go, to)
                n += 1
            else:
                _sift_up(keys, cells, slots, int(slots[to]), new + to_go, to)
    for row in range(out.shape[0]):
        for col in range(cols):
            if slots[row * cols + col] != EXPANDED:
                out[row, col] = inf
