"""Dijkstra's algorithm with buckets, and A* with a binary heap that contains each cell at most once.

Dijkstra's algorithm computes the cost-to-come of every cell that costs no more than the goal. Cells are kept in buckets
narrower than the cheapest step. No step leads from a bucket into the same one, so the cells of the lowest bucket are
final in any order, and no heap is needed. Source: Dial, Algorithm 360: Shortest-Path Forest with
Topological Ordering, 1969.
"""

from __future__ import annotations

from math import inf

import numpy as np

from mapper.core.array_types import Float64Array, Int32Array, UInt8Array
from mapper.core.jit import jit
from mapper.planning.kernels.steps import D_COL, D_ROW, DIAGONAL, _is_open


@jit
def spread(
    costs: UInt8Array,
    table: Float64Array,
    start: int,
    goal: int,
    width: float,
    heads: Int32Array,
    after: Int32Array,
    before: Int32Array,
    out: Float64Array,
) -> None:
    """Write the cost-to-come (rows, cols) from ``start``; infinity for cells that cost more than ``goal``.

    With a ``goal`` below 0 all cells are covered. Numba twin of :func:`mapper.planning.textbook.dijkstra`. Cells are
    row · cols + col. ``width``, that of a bucket, is less than the cheapest step. ``heads`` (more than the most
    expensive step / width + 1,) and ``after`` and ``before`` (rows · cols,) are working memory: each bucket is a doubly
    linked list of cells.
    """
    cols = costs.shape[1]
    n = heads.shape[0]
    out[:] = inf
    heads[:] = -1
    out[start // cols, start % cols] = 0.0
    heads[0], after[start], before[start] = start, -1, -1
    waiting, bucket = 1, 0
    while waiting > 0:
        slot = bucket % n
        while heads[slot] >= 0:
            cell = np.int64(heads[slot])
            heads[slot] = after[cell]
            if after[cell] >= 0:
                before[after[cell]] = -1
            waiting -= 1
            row, col = cell // cols, cell % cols
            cost = out[row, col]
            for k in range(8):
                if not _is_open(costs, table, row, col, k):
                    continue
                to_row, to_col = row + D_ROW[k], col + D_COL[k]
                step = table[costs[to_row, to_col]]
                new = cost + (step if k < 4 else step * DIAGONAL)
                old = out[to_row, to_col]
                if not new < old:
                    continue
                to = to_row * cols + to_col
                place = int(new / width) % n
                out[to_row, to_col] = new
                if old < inf:
                    former = int(old / width) % n
                    if former == place:
                        continue
                    if before[to] >= 0:
                        after[before[to]] = after[to]
                    else:
                        heads[former] = after[to]
                    if after[to] >= 0:
                        before[after[to]] = before[to]
                    waiting -= 1
                after[to], before[to] = heads[place], -1
                if heads[place] >= 0:
                    before[heads[place]] = to
                heads[place] = to
                waiting += 1
        most = out[goal // cols, goal % cols] if goal >= 0 else inf
        if most < inf and int(most / width) <= bucket:
            break
        bucket += 1
    most = out[goal // cols, goal % cols] if goal >= 0 else inf
    if most < inf:
        for row in range(out.shape[0]):
            line = out[row]
            for col in range(cols):
                if line[col] > most:
                    line[col] = inf


NOT_WAITING, EXPANDED = -1, -2


@jit
def _sift_up(keys: Float64Array, cells: Int32Array, slots: Int32Array, k: int, key: float, cell: int) -> None:
    """Put a cell at slot ``k`` of the heap or above; cells are in the order of their keys, then of their numbers."""
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
    """Take the first of the ``n`` cells out of the heap."""
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
    """Write the cost to come (rows, cols) of the cells that A* expands; infinity elsewhere.

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
