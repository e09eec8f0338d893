"""Readings that a map does not explain at a pose: beams that pass through a wall, or end before one.

Numba twin of :func:`mapper.localization.textbook.count_unexplained`.
"""

from __future__ import annotations

from math import cos, sin

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.localization.kernels.beam_model import _expected_range
from mapper.localization.kernels.types import OccupiedCells


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
