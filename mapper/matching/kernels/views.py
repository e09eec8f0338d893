"""Correspondences of two scans by the bearing at which one scan would have seen the points of the other.

The nearest point of the other scan is searched among the beams around that bearing (projective data association: Blais
& Levine 1995), outwards, until no farther beam can have a nearer point (Censi 2008, section IV).
"""

from __future__ import annotations

from math import atan2, ceil, cos, floor, pi, sin, sqrt

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, POINT, ScanArrays


@jit
def _write_centres(scans: ScanArrays, j: int, xy: Float64Array, n: int, centres: Int64Array) -> None:
    """Write the beam of scan j that points towards each of n points ``xy`` (., 2) of its base frame.

    ``centres`` (n,) is −1 outside the field of view.
    """
    n_beams, first, step, wraps = scans.n_beams[j], scans.first[j], scans.step[j], scans.wraps[j]
    sensor_x, sensor_y = scans.sensor[j, 0], scans.sensor[j, 1]
    for k in range(n):
        turned = atan2(xy[k, 1] - sensor_y, xy[k, 0] - sensor_x) - first
        turned -= 2.0 * pi * floor(turned / (2.0 * pi))
        beam = int(turned / step + 0.5)
        if beam >= n_beams:
            beam = 0 if wraps or turned > 2.0 * pi - 0.5 * step else -1
        centres[k] = beam


@jit
def _beams_of_circle(scans: ScanArrays, j: int) -> int:
    """Return the number of beams of scan j for a field of view of 360°, rounded up.

    Rounded steps, as in a float32 message, do not increase it by one.
    """
    n_beams = int(scans.n_beams[j])
    return n_beams if scans.wraps[j] else max(n_beams, ceil(2.0 * pi / scans.step[j] - 0.01))


@jit
def _write_nearest(
    scans: ScanArrays,
    j: int,
    xy: Float64Array,
    n: int,
    centres: Int64Array,
    max_beams: Int64Array,
    gate: float,
    least: int,
    nearest: Int64Array,
) -> None:
    """Write the beam of scan j whose point is nearest to each of n points ``xy`` (., 2) of its base frame.

    The beams up to ``max_beams`` (n,) away from ``centres`` (n,), those that point there, are searched. A centre
    outside the field of view has the index that such a beam would have. Points of a kind below ``least`` are ignored.
    ``nearest`` (n,) is −1 if no point is within ``gate``, or the centre is −1. All points are processed in one call,
    because numba counts the references to each array in each call.
    """
    points, kind = scans.points[j], scans.kind[j]
    n_beams, step, wraps = scans.n_beams[j], scans.step[j], scans.wraps[j]
    sensor_x, sensor_y = scans.sensor[j, 0], scans.sensor[j, 1]
    ring = _beams_of_circle(scans, j)
    most = ring // 2
    # A point k beams away is at a distance of at least r · sin δ, δ ≥ (k − ½) · step, and sin δ ≥ δ − δ³ / 6. Across
    # the seam from the last to the first beam it may be less, because the steps need not divide the circle.
    excess = abs(ring * step - 2.0 * pi)
    widest = 0
    for p in range(n):
        widest = max(widest, min(max_beams[p], most))
    square_sines = np.zeros(widest + 1)
    for k in range(1, widest + 1):
        angle = min(max((k - 0.5) * step - excess, 0.0), 0.5 * pi)
        sine = angle - angle * angle * angle / 6.0
        square_sines[k] = sine * sine
    for p in range(n):
        centre, closest = centres[p], -1
        if centre >= 0:
            x, y = xy[p, 0], xy[p, 1]
            to_x, to_y = x - sensor_x, y - sensor_y
            square_r = to_x * to_x + to_y * to_y
            best = gate * gate
            for k in range(min(max_beams[p], most) + 1):
                if square_r * square_sines[k] >= best:
                    break
                for side in range(2 if k > 0 else 1):
                    b = centre - k if side == 0 else centre + k
                    if b < 0 or b >= ring:
                        b += ring if b < 0 else -ring
                    if b >= n_beams or (not wraps and abs(b - centre) > max_beams[p]):
                        continue
                    if kind[b] >= least:
                        d_x, d_y = points[b, 0] - x, points[b, 1] - y
                        square = d_x * d_x + d_y * d_y
                        if square < best:
                            best, closest = square, b
        nearest[p] = closest


@jit
def _pair_points(
    scans: ScanArrays, j: int, xy: Float64Array, n: int, gate: float, max_beams: int, least: int, nearest: Int64Array
) -> None:
    """Write the beam of scan j whose point is nearest to each of n points ``xy`` (., 2) of its base frame, metres.

    Beams up to ``max_beams`` away from the one that points there are searched. ``nearest`` (n,) is −1 if no point of
    kind ``least`` or above is within ``gate``, and −2 for a point outside the field of view. If ``max_beams`` covers
    all beams, a point outside the field of view has a nearest point too.
    """
    centres, limits = np.empty(n, dtype=np.int64), np.full(n, max_beams)
    _write_centres(scans, j, xy, n, centres)
    if max_beams >= scans.n_beams[j]:
        ring = _beams_of_circle(scans, j)
        limits[:] = ring
        for k in range(n):
            if centres[k] < 0:
                turned = atan2(xy[k, 1] - scans.sensor[j, 1], xy[k, 0] - scans.sensor[j, 0]) - scans.first[j]
                turned -= 2.0 * pi * floor(turned / (2.0 * pi))
                centres[k] = min(int(turned / scans.step[j] + 0.5), ring - 1)
    _write_nearest(scans, j, xy, n, centres, limits, gate, least, nearest)
    for k in range(n):
        if centres[k] < 0:
            nearest[k] = -2


@jit
def _measured_around(scans: ScanArrays, j: int, centre: int, beams: int) -> tuple[float, int]:
    """Return the minimum range of scan j among the ``beams`` beams on either side of one, and how many have a range.

    The minimum is 1e300 if none has.
    """
    n_beams = scans.n_beams[j]
    least, seen = 1e300, 0
    for beam in range(centre - beams, centre + beams + 1):
        b = beam
        if b < 0 or b >= n_beams:
            if not scans.wraps[j]:
                continue
            b += n_beams if b < 0 else -n_beams
        if scans.kind[j, b] != NO_POINT:
            x = np.float64(scans.points[j, b, 0]) - scans.sensor[j, 0]
            y = np.float64(scans.points[j, b, 1]) - scans.sensor[j, 1]
            least = min(least, sqrt(x * x + y * y))
            seen += 1
    return least, seen


@jit
def compare_views(
    moving: ScanArrays,
    i: int,
    pose: Float64Array,
    fixed: ScanArrays,
    j: int,
    at: Float64Array,
    gate: float,
    max_beams: int,
) -> tuple[int, int, int, float]:
    """Compare scan i of ``moving`` at ``pose`` with scan j of ``fixed`` at ``at``.

    Returned are the number of points nearer than ``gate`` to a point of the other scan; the number that the other scan
    saw through (farther than ``gate`` in front of its measurements in that direction and on either side); the number
    behind its measurements; and Σ (1 − d² / gate²) over the first, where d is the distance.
    """
    c_i, s_i, c_j, s_j = cos(pose[2]), sin(pose[2]), cos(at[2]), sin(at[2])
    turn_c, turn_s = c_j * c_i + s_j * s_i, c_j * s_i - s_j * c_i
    d_x, d_y = pose[0] - at[0], pose[1] - at[1]
    t_x, t_y = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
    xy, n = np.empty((moving.n_beams[i], 2)), 0
    for k in range(moving.n_beams[i]):
        if moving.kind[i, k] != NO_POINT:
            p_x, p_y = np.float64(moving.points[i, k, 0]), np.float64(moving.points[i, k, 1])
            xy[n, 0], xy[n, 1] = turn_c * p_x - turn_s * p_y + t_x, turn_s * p_x + turn_c * p_y + t_y
            n += 1
    centres, nearest = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    _write_centres(fixed, j, xy, n, centres)
    _write_nearest(fixed, j, xy, n, centres, np.full(n, max_beams), gate, POINT, nearest)
    near, through, behind, total = 0, 0, 0, 0.0
    for k in range(n):
        if centres[k] < 0:
            continue
        x, y, q = xy[k, 0], xy[k, 1], nearest[k]
        if q >= 0:
            o_x, o_y = np.float64(fixed.points[j, q, 0]) - x, np.float64(fixed.points[j, q, 1]) - y
            near += 1
            total += 1.0 - (o_x * o_x + o_y * o_y) / (gate * gate)
            continue
        to_x, to_y = x - fixed.sensor[j, 0], y - fixed.sensor[j, 1]
        r = sqrt(to_x * to_x + to_y * to_y)
        least, _ = _measured_around(fixed, j, centres[k], min(1, max_beams))
        if least > r + gate and least < 1e300:
            through += 1
        elif least < r - gate:
            behind += 1
    return near, through, behind, total
