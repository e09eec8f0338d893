"""Agreement of a scan with others: points on their walls, and points in their free space.

Numba twins of :func:`mapper.slam.textbook.agreement`, jointly and per scan.
"""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, POINT, ScanArrays
from mapper.matching.kernels.views import _measured_around, _write_centres, _write_nearest


@jit
def count_agreement(
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    others: Int64Array,
    poses: Float64Array,
    gate: float,
    stride: int,
    counts: Int64Array,
) -> None:
    """Count points of scan i at ``pose`` (3,) against the scans ``others`` at their ``poses`` (n_scans, 3).

    ``counts`` (3,) receives, for every ``stride``-th beam, the number of points examined, the number nearer than
    ``gate`` metres to a point of one of the others, and the number of the rest in free space of one: its three beams in
    that direction all end two gates or more behind the point. Points that the others could not see count as neither.
    Near points are searched among the beams that pass within a gate, at most 12° to either side.
    """
    counts[:] = 0
    c, s = cos(pose[2]), sin(pose[2])
    reach = 12.0 * pi / 180.0
    room = scans.n_beams[i] // stride + 1
    world, n = np.empty((room, 2)), 0
    for k in range(0, scans.n_beams[i], stride):
        if scans.kind[i, k] != NO_POINT:
            p_x, p_y = np.float64(scans.points[i, k, 0]), np.float64(scans.points[i, k, 1])
            world[n, 0], world[n, 1] = pose[0] + c * p_x - s * p_y, pose[1] + s * p_x + c * p_y
            n += 1
    counts[0] = n
    xy, is_free = np.empty((n, 2)), np.zeros(n, dtype=np.bool_)
    centres, halves = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    nearest = np.empty(n, dtype=np.int64)
    for j in others:
        c_j, s_j, step = cos(poses[j, 2]), sin(poses[j, 2]), scans.step[j]
        for k in range(n):
            d_x, d_y = world[k, 0] - poses[j, 0], world[k, 1] - poses[j, 1]
            xy[k, 0], xy[k, 1] = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
            r = hypot(xy[k, 0] - scans.sensor[j, 0], xy[k, 1] - scans.sensor[j, 1])
            halves[k] = int(min(gate / max(r, 0.3), reach) / step) + 1
        _write_centres(scans, j, xy, n, centres)
        _write_nearest(scans, j, xy, n, centres, halves, gate, POINT, nearest)
        # Remove the points already found near; the others move up.
        rest = 0
        for k in range(n):
            if nearest[k] >= 0:
                continue
            free = is_free[k]
            if centres[k] >= 0 and not free:
                r = hypot(xy[k, 0] - scans.sensor[j, 0], xy[k, 1] - scans.sensor[j, 1])
                least, seen = _measured_around(scans, j, centres[k], 1)
                free = seen == 3 and least >= r + 2.0 * gate
            world[rest, 0], world[rest, 1], is_free[rest] = world[k, 0], world[k, 1], free
            rest += 1
        n = rest
    counts[1], counts[2] = counts[0] - n, is_free[:n].sum()


@jit
def count_common(
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    others: Int64Array,
    poses: Float64Array,
    gate: float,
    stride: int,
    common: Int64Array,
) -> None:
    """Write for each of the scans ``others`` (k,) the number of points of scan i at ``pose`` that are on its walls
    (k,).
    """
    counts = np.empty(3, dtype=np.int64)
    for k in range(len(others)):
        count_agreement(scans, i, pose, others[k : k + 1], poses, gate, stride, counts)
        common[k] = counts[1]
