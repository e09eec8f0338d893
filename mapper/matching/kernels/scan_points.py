"""Points and normals of scans.

Numba twins of :func:`mapper.matching.textbook.scan_points` and :func:`mapper.matching.textbook.scan_normals`.
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, UInt8Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, POINT, POINT_WITH_NORMAL, ScanArrays


@jit
def write_points(
    ranges: Float32Array,
    beams: Float64Array,
    sensor: Float64Array,
    range_min: float,
    range_max: float,
    times: Float64Array,
    velocities: Float64Array,
    points: Float32Array,
    kind: UInt8Array,
) -> None:
    """Write the endpoint of each reading r with ``range_min`` ≤ r ≤ ``range_max`` in the base frame.

    ``ranges`` (n_scans, n_beams) metres; ``beams`` (n_beams, 2) cosine and sine of each bearing in the base frame,
    ``sensor`` (2,) their origin. During a scan the base moves with ``velocities`` (n_scans, 3) in its own frame, metres
    and radians per second. Beam b is measured ``times`` (n_beams,) seconds after the first, and its point is relative
    to the base's pose at the time of the first beam. ``points`` (n_scans, n_beams, 2) and ``kind`` (n_scans, n_beams)
    are written: 0 and NO_POINT for other readings.
    """
    for i in range(ranges.shape[0]):
        v_x, v_y, turning = velocities[i, 0], velocities[i, 1], velocities[i, 2]
        for k in range(ranges.shape[1]):
            r = np.float64(ranges[i, k])
            if range_min <= r <= range_max:
                x, y = sensor[0] + r * beams[k, 0], sensor[1] + r * beams[k, 1]
                if times[k] != 0.0:
                    c, s = cos(turning * times[k]), sin(turning * times[k])
                    x, y = c * x - s * y + v_x * times[k], s * x + c * y + v_y * times[k]
                points[i, k, 0], points[i, k, 1] = np.float32(x), np.float32(y)
                kind[i, k] = POINT
            else:
                points[i, k, 0] = points[i, k, 1] = np.float32(0.0)
                kind[i, k] = NO_POINT


@jit
def write_normals(
    scans: ScanArrays, half_width: int, reach: float, most: int, least_gap: float, max_thickness: float
) -> None:
    """Write the normal of the line through each point and its neighbours in bearing, if they lie on a line.

    Neighbours are the points of the ``half_width`` beams on either side, or of the beams within ``reach`` metres across
    at that range, at most ``most``, if they are not separated by a gap: the larger of ``least_gap`` metres and three
    times the distance between beams at that range, for each beam in between. The line is the major axis of their
    scatter. A normal requires at least three points, and a scatter along the line of 8 times that across, or a scatter
    across below ``max_thickness``² m². ``scans.normals`` and ``scans.kind`` are written.
    """
    points, normals, kind = scans.points, scans.normals, scans.kind
    for i in range(points.shape[0]):
        n_beams, step = scans.n_beams[i], scans.step[i]
        for k in range(points.shape[1]):
            normals[i, k, 0] = normals[i, k, 1] = np.float32(0.0)
            if kind[i, k] == NO_POINT:
                continue
            x, y = np.float64(points[i, k, 0]), np.float64(points[i, k, 1])
            to_x, to_y = x - scans.sensor[i, 0], y - scans.sensor[i, 1]
            r = sqrt(to_x * to_x + to_y * to_y)
            gap = max(least_gap, 3.0 * r * step)
            half = max(half_width, int(min(reach / max(r * step, 1e-9), np.float64(most))))
            half = min(half, (n_beams - 1) // 2)
            n, s_x, s_y, s_xx, s_xy, s_yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
            for offset in range(-half, half + 1):
                q = k + offset
                if scans.wraps[i]:
                    q += n_beams if q < 0 else -n_beams if q >= n_beams else 0
                if q < 0 or q >= n_beams or kind[i, q] == NO_POINT:
                    continue
                d_x, d_y = np.float64(points[i, q, 0]) - x, np.float64(points[i, q, 1]) - y
                if sqrt(d_x * d_x + d_y * d_y) < gap * max(1, abs(offset)):
                    n += 1
                    s_x += d_x
                    s_y += d_y
                    s_xx += d_x * d_x
                    s_xy += d_x * d_y
                    s_yy += d_y * d_y
            if n < 3:
                continue
            m_x, m_y = s_x / n, s_y / n
            c_xx, c_xy, c_yy = s_xx / n - m_x * m_x, s_xy / n - m_x * m_y, s_yy / n - m_y * m_y
            along = 0.5 * atan2(2.0 * c_xy, c_xx - c_yy)
            n_x, n_y = -sin(along), cos(along)
            across = c_xx * n_x * n_x + 2.0 * c_xy * n_x * n_y + c_yy * n_y * n_y
            if c_xx + c_yy - across > 8.0 * across or across < max_thickness * max_thickness:
                if n_x * to_x + n_y * to_y > 0.0:
                    n_x, n_y = -n_x, -n_y
                normals[i, k, 0], normals[i, k, 1] = np.float32(n_x), np.float32(n_y)
                kind[i, k] = POINT_WITH_NORMAL
