"""Line segments of a scan by split and merge. Numba twin of :func:`mapper.matching.textbook.split`."""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, ScanArrays


@jit
def split_scan(scans: ScanArrays, i: int, least_gap: float, thickness: float, fewest: int, segments: Int64Array) -> int:
    """Write the first and last beam of each straight run of points of scan i; return their number.

    A run ends if the next beam with a point is farther away than the larger of ``least_gap`` metres and three times the
    distance between beams at that range, for each beam in between. A run is split at the point farthest from the line
    through its ends until none is farther than ``thickness`` metres; runs of fewer than ``fewest`` points are dropped.
    ``segments`` (n_beams, 2) is written in the order of the bearing. Source: Nguyen et al. 2007, split and merge with
    the iterative end-point fit.
    """
    points, kind = scans.points[i], scans.kind[i]
    n_beams = len(kind)
    used = np.empty(n_beams, dtype=np.int64)
    n = 0
    for k in range(n_beams):
        if kind[k] != NO_POINT:
            used[n] = k
            n += 1
    count, begin = 0, 0
    stack = np.empty((n_beams + 1, 2), dtype=np.int64)
    while begin < n:
        end = begin
        while end + 1 < n:
            a, b = used[end], used[end + 1]
            d_x, d_y = (
                np.float64(points[b, 0]) - np.float64(points[a, 0]),
                np.float64(points[b, 1]) - np.float64(points[a, 1]),
            )
            to_x, to_y = np.float64(points[a, 0]) - scans.sensor[i, 0], np.float64(points[a, 1]) - scans.sensor[i, 1]
            gap = max(least_gap, 3.0 * sqrt(to_x * to_x + to_y * to_y) * scans.step[i]) * (b - a)
            if sqrt(d_x * d_x + d_y * d_y) > gap:
                break
            end += 1
        stack[0, 0], stack[0, 1] = begin, end
        height = 1
        while height > 0:
            height -= 1
            first, last = stack[height, 0], stack[height, 1]
            if last - first + 1 < fewest:
                continue
            a, b = used[first], used[last]
            x, y = np.float64(points[a, 0]), np.float64(points[a, 1])
            d_x, d_y = np.float64(points[b, 0]) - x, np.float64(points[b, 1]) - y
            length = sqrt(d_x * d_x + d_y * d_y)
            farthest, at = 0.0, first
            for q in range(first + 1, last):
                p_x, p_y = np.float64(points[used[q], 0]) - x, np.float64(points[used[q], 1]) - y
                off = abs(p_x * d_y - p_y * d_x) / length if length > 0.0 else sqrt(p_x * p_x + p_y * p_y)
                if off > farthest:
                    farthest, at = off, q
            if farthest > thickness:
                # The later part is below the earlier one on the stack.
                stack[height, 0], stack[height, 1] = at, last
                stack[height + 1, 0], stack[height + 1, 1] = first, at
                height += 2
            else:
                segments[count, 0], segments[count, 1] = a, b
                count += 1
        begin = end + 1
    return count
