"""Shortest paths on a lattice of cells with a cost each."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.jit import jit

MOST_BUCKETS = 1 << 12
#: For each of the eight steps, in the order of the kernel: the two straight steps next to a diagonal one, else -1.
_SIDES = np.array([(1, 3), (-1, -1), (1, 4), (-1, -1), (-1, -1), (6, 3), (-1, -1), (6, 4)])


@jit
def shortest_paths(
    cost: NDArray[np.float64],
    start_row: int,
    start_col: int,
    distance: NDArray[np.float64],
    parent: NDArray[np.int64],
) -> None:
    """Write the cost of the cheapest 8-connected path from the start to every cell, and each cell's predecessor.

    ``cost`` (rows, cols) > 0 is the cost per metre (any unit) in each cell, +inf if impassable; a step costs the mean
    of its two cells times its length in cells. ``distance`` (rows, cols) is +inf for unreachable cells. ``parent``
    (rows, cols) holds flat indices, −1 at the start and for unreachable cells; of several equally cheap predecessors,
    the cell nearest to the start. A diagonal step requires both adjacent cells to be passable.

    Dijkstra's algorithm with buckets of distances in place of a heap: no step costs less than the width of a bucket, so
    the cells of one bucket do not shorten each other's paths (Dial 1969, Algorithm 360; Dinitz 1978). A cell that is
    still shortened because of rounding is processed again.
    """
    rows, cols = cost.shape
    distance[:, :] = np.inf
    parent[:, :] = -1
    if not (0 <= start_row < rows and 0 <= start_col < cols):
        return
    # A border of impassable cells avoids the tests for neighbours outside the lattice.
    wide = cols + 2
    costs, best = np.full((rows + 2) * wide, np.inf), np.full((rows + 2) * wide, np.inf)
    least, greatest = np.inf, 0.0
    for r in range(rows):
        for c in range(cols):
            here = cost[r, c]
            costs[(r + 1) * wide + c + 1] = here
            if here < np.inf:
                least, greatest = min(least, here), max(greatest, here)
    steps = np.array([-wide - 1, -wide, -wide + 1, -1, 1, wide - 1, wide, wide + 1])
    # A step reaches at most ``count`` buckets ahead, so they are used cyclically. Few buckets are wider than the
    # shortest step.
    count = min(MOST_BUCKETS, int(math.sqrt(2.0) * greatest / least) + 3) if greatest > 0.0 else 3
    width = max(least, math.sqrt(2.0) * greatest / (count - 2)) if greatest > 0.0 else 1.0
    first = np.full(
        count, -1, dtype=np.int32
    )  # cell of each bucket; the cells of one bucket form a list linked in both directions
    after, before = np.empty(len(best), dtype=np.int32), np.empty(len(best), dtype=np.int32)
    bucket_of, origin = np.full(len(best), -1, dtype=np.int32), np.full(len(best), -1, dtype=np.int32)
    start = (start_row + 1) * wide + start_col + 1
    best[start] = 0.0
    first[0], after[start], before[start], bucket_of[start] = start, -1, -1, 0
    waiting, bucket = 1, 0
    while waiting > 0:
        cell = np.int64(first[bucket])
        if cell < 0:
            bucket = bucket + 1 if bucket + 1 < count else 0
            continue
        first[bucket] = after[cell]
        if after[cell] >= 0:
            before[after[cell]] = -1
        bucket_of[cell] = -1
        waiting -= 1
        key = best[cell]
        for k in range(8):
            beside = cell + steps[k]
            there = costs[beside]
            if not there < np.inf:
                continue
            is_diagonal = _SIDES[k, 0] >= 0
            if is_diagonal:
                beside_1, beside_2 = cell + steps[_SIDES[k, 0]], cell + steps[_SIDES[k, 1]]
                if not (costs[beside_1] < np.inf and costs[beside_2] < np.inf):
                    continue
            # The start itself may be impassable; then only the entered cell counts.
            here = costs[cell] if costs[cell] < np.inf else there
            new = key + 0.5 * (here + there) * (math.sqrt(2.0) if is_diagonal else 1.0)
            if new >= best[beside]:
                if new == best[beside] and origin[beside] >= 0 and key < best[origin[beside]]:
                    origin[beside] = cell
                continue
            best[beside], origin[beside] = new, cell
            old = bucket_of[beside]
            into = int(new / width) % count
            if old == into:
                continue
            if old >= 0:  # remove it from its list
                if before[beside] >= 0:
                    after[before[beside]] = after[beside]
                else:
                    first[old] = after[beside]
                if after[beside] >= 0:
                    before[after[beside]] = before[beside]
            else:
                waiting += 1
            head = first[into]
            after[beside], before[beside], bucket_of[beside] = head, -1, into
            if head >= 0:
                before[head] = beside
            first[into] = beside
    for r in range(rows):
        for c in range(cols):
            cell = (r + 1) * wide + c + 1
            distance[r, c], cell_before = best[cell], np.int64(origin[cell])
            if cell_before >= 0:
                parent[r, c] = (cell_before // wide - 1) * cols + cell_before % wide - 1
