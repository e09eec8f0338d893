"""Shortest paths on a lattice of cells with a cost each, and the relaxation of their corners.

The relaxation is the twin of :func:`mapper.simulation.textbook.relaxed`, to the last bit: recorded stories depend on
the paths.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.simulation.kernels.raycast import _squared_distance, clearances, nearest_edge

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


GROUP = 8  # consecutive points that share a list of nearby edges
MOVED = 0.3  # metres along an axis that a point may move while that list is used
SLACK = 1e-9  # metres: the rounding of a distance


@jit
def _edges_near(segments: Float64Array, points: Float64Array, reach: float, out: NDArray[np.int32]) -> int:
    """List in ``out`` the edges that may be within ``reach`` metres of any of ``points`` (n, 2); return their
    number.
    """
    left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
    for i in range(points.shape[0]):
        left, right = min(left, points[i, 0] - reach), max(right, points[i, 0] + reach)
        low, high = min(low, points[i, 1] - reach), max(high, points[i, 1] + reach)
    count = 0
    for k in range(segments.shape[0]):
        ax, ay, bx, by = segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3]
        out[count] = k
        across = (min(ax, bx) <= right) & (max(ax, bx) >= left)
        count += 1 if across & (min(ay, by) <= high) & (max(ay, by) >= low) else 0
    return count


@jit
def relax(
    segments: Float64Array, bounds: tuple[float, float, float, float], path: Float64Array, least: float, rounds: int
) -> None:
    """Relax the corners of ``path`` (n, 2), metres, in place.

    ``segments`` as in :mod:`mapper.simulation.kernels.raycast`; ``bounds`` (x_min, y_min, x_max, y_max) metres. The
    clearance changes by no more than the distance moved. It is computed only if that bound is not sufficient, and
    without the inside test if the position is so near to a free one that no edge is between them.
    """
    n = path.shape[0]
    x_min, y_min, x_max, y_max = bounds
    known = np.empty(n)  # lower bound of the clearance of each point
    clearances(segments, path, known)
    floor = np.empty(n)
    for i in range(n):
        inside = x_min < path[i, 0] < x_max and y_min < path[i, 1] < y_max
        known[i] = known[i] if inside else -np.inf
        floor[i] = min(known[i], least)
    groups = -(-n // GROUP)
    near, counts = np.empty((groups, segments.shape[0] + 1), dtype=np.int32), np.empty(groups, dtype=np.int64)
    for g in range(groups):
        counts[g] = _edges_near(segments, path[g * GROUP : (g + 1) * GROUP], least + MOVED + SLACK, near[g])
    first, before = path.copy(), path.copy()
    nearest = np.empty(2)
    for _ in range(rounds):
        before[:] = path
        for i in range(1, n - 1):
            x = 0.5 * before[i, 0] + 0.25 * (before[i - 1, 0] + before[i + 1, 0])
            y = 0.5 * before[i, 1] + 0.25 * (before[i - 1, 1] + before[i + 1, 1])
            if not (x_min < x < x_max and y_min < y < y_max):
                if floor[i] == -np.inf:
                    path[i, 0], path[i, 1] = x, y
                continue
            moved = math.hypot(x - before[i, 0], y - before[i, 1])
            clearance = known[i] - moved - SLACK
            if not clearance >= floor[i]:
                if moved < floor[i] and abs(x - first[i, 0]) <= MOVED and abs(y - first[i, 1]) <= MOVED:
                    least_square = np.inf
                    group = i // GROUP
                    for at in range(counts[group]):
                        k = near[group, at]
                        ax, ay = segments[k, 0], segments[k, 1]
                        square = _squared_distance(ax, ay, segments[k, 2] - ax, segments[k, 3] - ay, x, y)
                        least_square = min(least_square, square)
                    clearance = min(math.sqrt(least_square), least + SLACK)  # beyond, edges may be missing in the list
                else:
                    clearance = nearest_edge(segments, x, y, nearest)
            if clearance >= floor[i]:
                path[i, 0], path[i, 1] = x, y
                known[i] = clearance
