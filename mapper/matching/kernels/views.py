"""Which points of two scans correspond, by the bearing in which one scan would have seen the points of the other.

The point of the other scan nearest to a point is looked for among the beams around that bearing (projective data
association: Blais & Levine 1995), outwards, until no farther beam can have a nearer point (Censi 2008, section IV).
"""

from __future__ import annotations

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, POINT, ScanArrays


@jit
def _beam_of(scans: ScanArrays, j: int, x: float, y: float) -> int:
    """Return the beam of scan j in whose direction a point (x, y) from its sensor lies, −1 where no beam points."""
    turned = atan2(y, x) - scans.first[j]
    turned -= 2.0 * pi * floor(turned / (2.0 * pi))
    beam = int(turned / scans.step[j] + 0.5)
    if beam < scans.n_beams[j]:
        return beam
    if scans.wraps[j] or turned > 2.0 * pi - 0.5 * scans.step[j]:
        return 0
    return -1


@jit
def _nearest_around(
    scans: ScanArrays, scan: int, x: float, y: float, centre: int, gate: float, max_beams: int, least: int
) -> int:
    """Return the beam of a scan whose point is nearest to (x, y), in its base frame, within ``gate``; −1 for none.

    The beams up to ``max_beams`` from ``centre``, the one that points there, are asked. Points of a kind below
    ``least`` do not count.
    """
    points, kind = scans.points[scan], scans.kind[scan]
    n_beams, step, wraps = scans.n_beams[scan], scans.step[scan], scans.wraps[scan]
    to_x, to_y = x - scans.sensor[scan, 0], y - scans.sensor[scan, 1]
    square_r = to_x * to_x + to_y * to_y
    best, found = gate * gate, -1
    last = min(max_beams, n_beams // 2 if wraps else n_beams)
    for k in range(last + 1):
        if k > 0:
            # A point k beams off is at least r · sin δ away, δ ≥ (k − ½) · step, and sin δ ≥ δ − δ³ / 6.
            angle = min((k - 0.5) * step, 0.5 * pi)
            sine = angle - angle * angle * angle / 6.0
            if square_r * (sine * sine) >= best:
                break
        for b in (centre - k, centre + k):
            if b < 0 or b >= n_beams:
                if not wraps:
                    continue
                b += n_beams if b < 0 else -n_beams  # noqa: PLW2901
            if kind[b] >= least:
                d_x, d_y = points[b, 0] - x, points[b, 1] - y
                square = d_x * d_x + d_y * d_y
                if square < best:
                    best, found = square, b
    return found


@jit
def _nearest_beam(scans: ScanArrays, scan: int, x: float, y: float, gate: float, max_beams: int, least: int) -> int:
    """Return :func:`_nearest_around` the beam that points to (x, y), −2 where (x, y) is outside the field of view.

    Where ``max_beams`` is all beams, a point outside the field of view has a nearest point too.
    """
    n_beams = scans.n_beams[scan]
    centre = _beam_of(scans, scan, x - scans.sensor[scan, 0], y - scans.sensor[scan, 1])
    if centre < 0:
        if max_beams < n_beams:
            return -2
        middle = scans.first[scan] + 0.5 * (n_beams - 1) * scans.step[scan]
        bearing = atan2(y - scans.sensor[scan, 1], x - scans.sensor[scan, 0])
        centre = 0 if sin(bearing - middle) < 0.0 else n_beams - 1
    return _nearest_around(scans, scan, x, y, centre, gate, max_beams, least)


@jit
def _measured_around(scans: ScanArrays, j: int, centre: int, beams: int) -> tuple[float, int]:
    """Return the least range that scan j has among the ``beams`` beams on either side of one, and how many have any.

    The range is 1e300 where none has.
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
    """Return how what scan i of ``moving`` at ``pose`` saw agrees with what scan j of ``fixed`` at ``at`` saw.

    Returned are the number of points nearer than ``gate`` to a point of the other scan; of those that the other scan
    saw through: farther than ``gate`` in front of what it measured in that direction and on either side; of those
    behind what it measured; and Σ (1 − d² / gate²) over the first, where d is the distance.
    """
    c_i, s_i, c_j, s_j = cos(pose[2]), sin(pose[2]), cos(at[2]), sin(at[2])
    turn_c, turn_s = c_j * c_i + s_j * s_i, c_j * s_i - s_j * c_i
    d_x, d_y = pose[0] - at[0], pose[1] - at[1]
    t_x, t_y = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
    near, through, behind, total = 0, 0, 0, 0.0
    for k in range(moving.n_beams[i]):
        if moving.kind[i, k] == NO_POINT:
            continue
        p_x, p_y = np.float64(moving.points[i, k, 0]), np.float64(moving.points[i, k, 1])
        x, y = turn_c * p_x - turn_s * p_y + t_x, turn_s * p_x + turn_c * p_y + t_y
        to_x, to_y = x - fixed.sensor[j, 0], y - fixed.sensor[j, 1]
        centre = _beam_of(fixed, j, to_x, to_y)
        if centre < 0:
            continue
        q = _nearest_around(fixed, j, x, y, centre, gate, max_beams, POINT)
        if q >= 0:
            o_x, o_y = np.float64(fixed.points[j, q, 0]) - x, np.float64(fixed.points[j, q, 1]) - y
            near += 1
            total += 1.0 - (o_x * o_x + o_y * o_y) / (gate * gate)
            continue
        r = sqrt(to_x * to_x + to_y * to_y)
        least, _ = _measured_around(fixed, j, centre, min(1, max_beams))
        if least > r + gate and least < 1e300:
            through += 1
        elif least < r - gate:
            behind += 1
    return near, through, behind, total
