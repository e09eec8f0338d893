"""Dijkstra's algorithm with buckets: the cost-to-come of every cell that costs no more than the goal.

Cells are kept in buckets narrower than the cheapest step. No step leads from a bucket into the same one, so the cells
of the lowest bucket are final in any order, and no heap is needed. Source: Dial, Algorithm 360: Shortest-Path Forest
with Topological Ordering, 1969.
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
