"""Steps between the cells of a costmap, and backtracking along the cost-to-come."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from mapper.core.array_types import Float64Array, Int32Array, UInt8Array
from mapper.core.jit import jit

D_ROW = np.array([0, 0, -1, 1, -1, -1, 1, 1])  #: in the order of mapper.planning.textbook.NEIGHBOURS
D_COL = np.array([-1, 1, 0, 0, -1, 1, -1, 1])
DIAGONAL = sqrt(2.0)


@jit
def _is_open(costs: UInt8Array, table: Float64Array, row: int, col: int, k: int) -> bool:
    """Return whether step ``k`` from a cell stays in the map and does not pass between two blocked cells.

    It does not check whether the target cell is blocked.
    """
    to_row, to_col = row + D_ROW[k], col + D_COL[k]
    if to_row < 0 or to_col < 0 or to_row >= costs.shape[0] or to_col >= costs.shape[1]:
        return False
    return k < 4 or table[costs[row, to_col]] < inf or table[costs[to_row, col]] < inf


@jit
def trace_back(
    costs: UInt8Array, table: Float64Array, potential: Float64Array, start: int, goal: int, out: Int32Array
) -> int:
    """Write the cells of the cheapest path, from the goal to the start, into ``out``; return their number.

    Cells are row · cols + col. Numba twin of :func:`mapper.planning.textbook.path_back`, in reverse order. No more
    cells than ``out`` holds are written.
    """
    cols = costs.shape[1]
    here, n = goal, 0
    while n < out.shape[0]:
        out[n] = here
        n += 1
        if here == start:
            break
        row, col = here // cols, here % cols
        step = table[costs[row, col]]
        best, before = inf, here
        for k in range(8):
            if not _is_open(costs, table, row, col, k):
                continue
            cell_row, cell_col = row + D_ROW[k], col + D_COL[k]
            cost = potential[cell_row, cell_col] + (step if k < 4 else step * DIAGONAL)
            if cost < best:
                best, before = cost, cell_row * cols + cell_col
        if before == here:
            break
        here = before
    return n
