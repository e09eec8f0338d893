"""Planes of patches by consensus; :mod:`mapper.terrain.textbook` is the same in plain NumPy."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.jit import jit

FLATNESS = 1e-6


@jit
def consensus(points: Float64Array, starts: Int64Array, trials: int, distance: float, out: BoolArray) -> None:
    """Write which points (n, 3) are within ``distance`` along z of the plane with most inliers in their patch.

    The points of patch k are ``starts[k]`` to ``starts[k + 1]``. Candidate planes pass through three of them: all
    triples if there are at most ``trials``, else ``trials`` random ones, which depend only on the number of points.
    """
    out[:] = False
    for patch in range(len(starts) - 1):
        first, n = starts[patch], starts[patch + 1] - starts[patch]
        if n < 3:
            continue
        is_every = n * (n - 1) * (n - 2) // 6 <= trials
        count = n * (n - 1) * (n - 2) // 6 if is_every else trials
        state, i, j, k = np.int64(n), 0, 1, 1
        most, best_a, best_b, best_c = 0, 0.0, 0.0, 0.0
        for _ in range(count):
            if is_every:
                k += 1
                if k == n:
                    j += 1
                    if j == n - 1:
                        i += 1
                        j = i + 1
                    k = j + 1
            else:
                state = (1664525 * state + 1013904223) & 0xFFFFFFFF
                i = (state >> 8) % n
                state = (1664525 * state + 1013904223) & 0xFFFFFFFF
                j = (state >> 8) % (n - 1)
                state = (1664525 * state + 1013904223) & 0xFFFFFFFF
                k = (state >> 8) % (n - 2)
                j += j >= i
                low, high = min(i, j), max(i, j)
                k += k >= low
                k += k >= high
            p, q, r = points[first + i], points[first + j], points[first + k]
            ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
            vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
            cross = ux * vy - uy * vx
            wx, wy = vx - ux, vy - uy
            # Determinant and trace of the scatter matrix of the three points.
            trace = (ux * ux + uy * uy + vx * vx + vy * vy + wx * wx + wy * wy) / 3.0
            if cross * cross / 3.0 <= FLATNESS * trace * trace:
                continue
            b, c = (uz * vy - vz * uy) / cross, (ux * vz - vx * uz) / cross
            a = p[2] - b * p[0] - c * p[1]
            inside = 0
            for m in range(first, first + n):
                inside += abs(points[m, 2] - a - b * points[m, 0] - c * points[m, 1]) <= distance
            if inside > most:
                most, best_a, best_b, best_c = inside, a, b, c
        if most:
            for m in range(first, first + n):
                out[m] = abs(points[m, 2] - best_a - best_b * points[m, 0] - best_c * points[m, 1]) <= distance
