"""A scan at a pose in a map: its score in the likelihood field, and readings that the map does not explain.

Not explained are beams that go on behind a wall, and such as end before one. Numba twins of
:func:`mapper.localization.textbook.field_score` and :func:`mapper.localization.textbook.count_unexplained`.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.localization.kernels.beam_model import _expected_range
from mapper.localization.kernels.types import OccupiedCells, ScoreField


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


@jit
def count_unexplained(
    cells: OccupiedCells,
    beams: Float64Array,
    sensor: Float64Array,
    pose: Float64Array,
    turn: float,
    margin: float,
    range_max: float,
) -> tuple[int, int]:
    """Return how many readings are longer, and how many shorter, than the map allows at ``pose`` (3,).

    The map allows ranges from ``margin`` metres below the minimum to ``margin`` above the maximum of three expected
    ranges: of the beam, and of the beam rotated by ``turn`` radians to either side. ``beams`` (k, 2) are range, at most
    ``range_max``, and bearing in the base's frame; ``sensor`` (2,) is their origin in it.
    """
    c, s = cos(pose[2]), sin(pose[2])
    x = pose[0] + c * sensor[0] - s * sensor[1]
    y = pose[1] + s * sensor[0] + c * sensor[1]
    longer, shorter = 0, 0
    for b in range(beams.shape[0]):
        z = beams[b, 0]
        far = min(range_max, z + 2.0 * margin)  # a longer range is equivalent to this one
        bearing = pose[2] + beams[b, 1]
        shortest = longest = _expected_range(cells, x, y, bearing, far)
        if longest + margin >= z >= shortest - margin:
            continue
        for side in range(-1, 2, 2):
            expected = _expected_range(cells, x, y, bearing + side * turn, far)
            shortest, longest = min(shortest, expected), max(longest, expected)
        if z > longest + margin:
            longer += 1
        elif z < shortest - margin:
            shorter += 1
    return longer, shorter
