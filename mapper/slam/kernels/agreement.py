"""How well a scan agrees with others: points on their walls, and points where they saw free space.

Numba twins of :func:`mapper.slam.textbook.agreement` and of its use for each scan by itself.
"""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, POINT, ScanArrays
from mapper.matching.kernels.views import _beam_of, _measured_around, _nearest_around


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

    ``counts`` (3,) gets how many of each ``stride``-th beam's points were looked at, how many are nearer than ``gate``
    metres to a point of one of the others, and how many are not but lie in free space of one: its three beams in that
    direction all end two gates or more behind the point. What the others could not see counts as neither. Near points
    are looked for among the beams that pass within a gate, at most 12° to either side.
    """
    counts[:] = 0
    c, s = cos(pose[2]), sin(pose[2])
    reach = 12.0 * pi / 180.0
    for k in range(0, scans.n_beams[i], stride):
        if scans.kind[i, k] == NO_POINT:
            continue
        p_x, p_y = np.float64(scans.points[i, k, 0]), np.float64(scans.points[i, k, 1])
        w_x, w_y = pose[0] + c * p_x - s * p_y, pose[1] + s * p_x + c * p_y
        counts[0] += 1
        is_near, is_free = False, False
        for j in others:
            c_j, s_j = cos(poses[j, 2]), sin(poses[j, 2])
            d_x, d_y = w_x - poses[j, 0], w_y - poses[j, 1]
            x, y = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
            v_x, v_y = x - scans.sensor[j, 0], y - scans.sensor[j, 1]
            centre = _beam_of(scans, j, v_x, v_y)
            if centre < 0:
                continue
            r = hypot(v_x, v_y)
            half = int(min(gate / max(r, 0.3), reach) / scans.step[j]) + 1
            if _nearest_around(scans, j, x, y, centre, gate, half, POINT) >= 0:
                is_near = True
                break
            least, seen = _measured_around(scans, j, centre, 1)
            if seen == 3 and least >= r + 2.0 * gate:
                is_free = True
        if is_near:
            counts[1] += 1
        elif is_free:
            counts[2] += 1


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
    """Write for each of the scans ``others`` (k,) how many points of scan i at ``pose`` are on its walls (k,)."""
    counts = np.empty(3, dtype=np.int64)
    for k in range(len(others)):
        count_agreement(scans, i, pose, others[k : k + 1], poses, gate, stride, counts)
        common[k] = counts[1]
