"""Moments and planes of patches, and the points that agree on a plane; in NumPy in :mod:`mapper.terrain.textbook`.

Moments (rows, cols, 10) float64 are the entries of P in the order n, x, y, z, xx, xy, yy, xz, yz, zz, about the
patch's centre. Planes (rows, cols, 6) float64 are a, b, c, mean height, roughness, slope; NaN where there is none.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.jit import jit

FLATNESS = 1e-6
_BATCH = 128  # points


@jit
def add_points(points: Float64Array, corner: Float64Array, size: float, out: Float64Array) -> None:
    """Add points (n, 3) to the moments of their patches. Heights are above the corner; points outside are left out.

    The order of the sums is that of the points. Each :data:`_BATCH` of points is gone through twice: the first loop
    only reads a number of each patch, so that the memory of many patches is fetched at the same time. Indices of arrays
    are unsigned because numba tests signed ones for being negative.
    """
    rows, cols, _ = out.shape
    flat = out.reshape(rows * cols, 10)
    per_metre = 1.0 / size
    x0, y0, z0 = corner[0], corner[1], corner[2]
    patches, fetched = np.empty(_BATCH, dtype=np.int64), np.empty(_BATCH)
    xs, ys, zs = np.empty(_BATCH), np.empty(_BATCH), np.empty(_BATCH)
    for first in range(0, len(points), _BATCH):
        n = min(_BATCH, len(points) - first)
        for k in range(n):
            point = points[np.uint64(first + k)]
            u, v = point[0] - x0, point[1] - y0
            col, row = np.floor(u * per_metre), np.floor(v * per_metre)
            inside = (col >= 0.0) & (col < cols) & (row >= 0.0) & (row < rows)
            patch = int(row) * cols + int(col) if inside else -1
            patches[k] = patch
            xs[k], ys[k], zs[k] = u - (col + 0.5) * size, v - (row + 0.5) * size, point[2] - z0
            if inside:
                fetched[k] = flat[np.uint64(patch), 0] + flat[np.uint64(patch), 9]
        for k in range(n):
            if patches[k] < 0:
                continue
            cell, x, y, z = flat[np.uint64(patches[k])], xs[k], ys[k], zs[k]
            cell[0] += 1.0
            cell[1] += x
            cell[2] += y
            cell[3] += z
            cell[4] += x * x
            cell[5] += x * y
            cell[6] += y * y
            cell[7] += x * z
            cell[8] += y * z
            cell[9] += z * z


@jit
def sum_areas(moments: Float64Array, size: float, out: Float64Array) -> None:
    """Write the summed-area table (rows + 1, cols + 1, 10): entry (r, c) has all patches before row r and column c.

    Its moments are about the middle of the grid.
    """
    rows, cols, _ = moments.shape
    line = np.empty(10)
    out[0] = 0.0
    for row in range(rows):
        line[:] = 0.0
        out[row + 1, 0] = 0.0
        dy = (row + 0.5 - 0.5 * rows) * size
        for col in range(cols):
            dx = (col + 0.5 - 0.5 * cols) * size
            m, above, here = moments[row, col], out[row, col + 1], out[row + 1, col + 1]
            n, x, y, z = m[0], m[1], m[2], m[3]
            line[0] += n
            line[1] += x + n * dx
            line[2] += y + n * dy
            line[3] += z
            line[4] += m[4] + 2.0 * dx * x + n * dx * dx
            line[5] += m[5] + dx * y + dy * x + n * dx * dy
            line[6] += m[6] + 2.0 * dy * y + n * dy * dy
            line[7] += m[7] + dx * z
            line[8] += m[8] + dy * z
            line[9] += m[9]
            for k in range(10):
                here[k] = above[k] + line[k]


@jit
def fit_windows(table: Float64Array, size: float, reach: int, min_points: int, out: Float64Array) -> None:
    """Write the planes of windows of 2 · ``reach`` + 1 patches a side from a summed-area table.

    A window ends at the border of the grid. A plane's a is the height at the centre of the window's middle patch.
    """
    rows, cols = out.shape[0], out.shape[1]
    for row in range(rows):
        low, high = max(row - reach, 0), min(row + reach + 1, rows)
        dy = (row + 0.5 - 0.5 * rows) * size
        for col in range(cols):
            left, right = max(col - reach, 0), min(col + reach + 1, cols)
            p, q, s, t = table[high, right], table[low, right], table[high, left], table[low, left]
            plane = out[row, col]
            n = (p[0] - q[0]) - (s[0] - t[0])
            if n < 1.0:
                plane[:] = np.nan
                continue
            per = 1.0 / n
            x = ((p[1] - q[1]) - (s[1] - t[1])) * per
            y = ((p[2] - q[2]) - (s[2] - t[2])) * per
            z = ((p[3] - q[3]) - (s[3] - t[3])) * per
            plane[3] = z
            xx = ((p[4] - q[4]) - (s[4] - t[4])) * per - x * x
            xy = ((p[5] - q[5]) - (s[5] - t[5])) * per - x * y
            yy = ((p[6] - q[6]) - (s[6] - t[6])) * per - y * y
            det = xx * yy - xy * xy
            if n < min_points or det <= FLATNESS * (xx + yy) * (xx + yy):
                plane[0] = plane[1] = plane[2] = plane[4] = plane[5] = np.nan
                continue
            xz = ((p[7] - q[7]) - (s[7] - t[7])) * per - x * z
            yz = ((p[8] - q[8]) - (s[8] - t[8])) * per - y * z
            zz = ((p[9] - q[9]) - (s[9] - t[9])) * per - z * z
            per = 1.0 / det
            b, c = (xz * yy - yz * xy) * per, (yz * xx - xz * xy) * per
            dx = (col + 0.5 - 0.5 * cols) * size
            plane[0], plane[1], plane[2] = z + b * (dx - x) + c * (dy - y), b, c
            plane[4] = math.sqrt(max(zz - b * xz - c * yz, 0.0))
            plane[5] = math.atan(math.sqrt(b * b + c * c))


@jit
def halve(moments: Float64Array, size: float, out: Float64Array) -> None:
    """Add the patches of ``size`` to their parents' moments, the next level of the quadtree."""
    for row in range(moments.shape[0]):
        dy = (row % 2 - 0.5) * size
        for col in range(moments.shape[1]):
            dx = (col % 2 - 0.5) * size
            m, p = moments[row, col], out[row // 2, col // 2]
            n, x, y, z = m[0], m[1], m[2], m[3]
            p[0] += n
            p[1] += x + n * dx
            p[2] += y + n * dy
            p[3] += z
            p[4] += m[4] + 2.0 * dx * x + n * dx * dx
            p[5] += m[5] + dx * y + dy * x + n * dx * dy
            p[6] += m[6] + 2.0 * dy * y + n * dy * dy
            p[7] += m[7] + dx * z
            p[8] += m[8] + dy * z
            p[9] += m[9]


@jit
def steps_between(planes: Float64Array, size: float, out: Float64Array) -> None:
    """Write the greatest gap (rows, cols) between a patch's plane and a neighbour's in the middle of their edge."""
    rows, cols, _ = planes.shape
    half = 0.5 * size
    out[:] = 0.0
    for row in range(rows):
        for col in range(cols):
            here = planes[row, col]
            if math.isnan(here[0]):
                out[row, col] = np.nan
                continue
            if col + 1 < cols and not math.isnan(planes[row, col + 1, 0]):
                there = planes[row, col + 1]
                gap = abs((here[0] + here[1] * half) - (there[0] - there[1] * half))
                out[row, col], out[row, col + 1] = max(out[row, col], gap), max(out[row, col + 1], gap)
            if row + 1 < rows and not math.isnan(planes[row + 1, col, 0]):
                there = planes[row + 1, col]
                gap = abs((here[0] + here[2] * half) - (there[0] - there[2] * half))
                out[row, col], out[row + 1, col] = max(out[row, col], gap), max(out[row + 1, col], gap)


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
