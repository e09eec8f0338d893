"""Score of a scan in the likelihood field at each of many poses.

Numba twin of :func:`mapper.localization.textbook.field_score`.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.localization.kernels.types import ScoreField


@jit
def score_poses(
    field: ScoreField, points: Float64Array, poses: Float64Array, first: int, last: int, out: Int64Array
) -> None:
    """Write the sum of the field's scores at the endpoints into ``out`` (n,), for the poses [first, last).

    ``points`` (k, 2) are the endpoints in the base's frame, metres; ``poses`` (n, 3) are ``T_map_base``. The sums are
    of integers, so their order does not matter.
    """
    scores, frame = field.scores, field.frame
    rows, cols = scores.shape
    k = points.shape[0]
    x, y = np.empty(k), np.empty(k)
    for b in range(k):
        x[b], y[b] = points[b, 0] / frame.resolution, points[b, 1] / frame.resolution
    for i in range(first, last):
        dx, dy = poses[i, 0] - frame.origin_x, poses[i, 1] - frame.origin_y
        u0 = (frame.cos_yaw * dx + frame.sin_yaw * dy) / frame.resolution
        v0 = (frame.cos_yaw * dy - frame.sin_yaw * dx) / frame.resolution
        c_map, s_map = cos(poses[i, 2]), sin(poses[i, 2])
        c = frame.cos_yaw * c_map + frame.sin_yaw * s_map
        s = frame.cos_yaw * s_map - frame.sin_yaw * c_map
        total = 0
        for b in range(k):
            u = u0 + c * x[b] - s * y[b]
            v = v0 + s * x[b] + c * y[b]
            if 0.0 <= u < cols and 0.0 <= v < rows:
                total += int(np.int64(scores[int(v), int(u)]))
        out[i] = total
