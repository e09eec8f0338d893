"""How well a scan agrees with others: points on their walls, and points where they saw free space."""

from __future__ import annotations

from math import atan2, cos, floor, hypot, pi, sin

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, ScanArrays


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
    direction all end more than two gates behind the point. What the others could not see counts as neither.
    """
    counts[:] = 0
    c, s = cos(pose[2]), sin(pose[2])
    n_beams = scans.points.shape[1]
    reach = 12.0 * pi / 180.0
    for k in range(0, n_beams, stride):
        if scans.kind[i, k] == NO_POINT:
            continue
        p_x, p_y = float(scans.points[i, k, 0]), float(scans.points[i, k, 1])
        w_x, w_y = pose[0] + c * p_x - s * p_y, pose[1] + s * p_x + c * p_y
        counts[0] += 1
        is_near, is_free = False, False
        for j in others:
            c_j, s_j = cos(poses[j, 2]), sin(poses[j, 2])
            d_x, d_y = w_x - poses[j, 0], w_y - poses[j, 1]
            x, y = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
            v_x, v_y = x - scans.sensor_x, y - scans.sensor_y
            turned = atan2(v_y, v_x) - scans.first
            turned -= 2.0 * pi * floor(turned / (2.0 * pi))
            centre = int(turned / scans.step + 0.5)
            if centre >= n_beams:
                if not scans.wraps:
                    continue
                centre = 0
            r = hypot(v_x, v_y)
            half = int(min(gate / max(r, 0.3), reach) / scans.step) + 1
            behind, seen = True, 0
            for q in range(centre - half, centre + half + 1):
                b = q % n_beams if scans.wraps else q
                if b < 0 or b >= n_beams or scans.kind[j, b] == NO_POINT:
                    continue
                o_x, o_y = float(scans.points[j, b, 0]), float(scans.points[j, b, 1])
                if (o_x - x) * (o_x - x) + (o_y - y) * (o_y - y) < gate * gate:
                    is_near = True
                    break
                if abs(q - centre) <= 1:
                    seen += 1
                    if hypot(o_x - scans.sensor_x, o_y - scans.sensor_y) < r + 2.0 * gate:
                        behind = False
            if is_near:
                break
            if behind and seen == 3:
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
