"""Relaxation of the corners of a path.

Twin of :func:`mapper.simulation.textbook.relaxed`, to the last bit, because the paths of recorded stories depend on it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.simulation.kernels.raycast import _squared_distance, clearances, nearest_edge

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
