"""Readings that a map cannot explain at a pose: beams that go on behind a wall.

Numba twin of :func:`mapper.localization.textbook.count_contradicted`.
"""

from __future__ import annotations

from math import cos, sin

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.localization.kernels.beam_model import _expected_range
from mapper.localization.kernels.types import OccupiedCells


@jit
def count_contradicted(
    cells: OccupiedCells,
    beams: Float64Array,
    sensor: Float64Array,
    pose: Float64Array,
    turn: float,
    margin: float,
    range_max: float,
) -> int:
    """Return how many readings are longer than the map allows at ``pose`` (3,) by more than ``margin`` metres.

    The map allows the longest of three expected ranges: of the beam, and of those turned by ``turn`` radians to either
    side. ``beams`` (k, 2) are range, at most ``range_max``, and bearing in the base's frame; ``sensor`` (2,) is where
    they start in it.
    """
    c, s = cos(pose[2]), sin(pose[2])
    x = pose[0] + c * sensor[0] - s * sensor[1]
    y = pose[1] + s * sensor[0] + c * sensor[1]
    count = 0
    for b in range(beams.shape[0]):
        longest = 0.0
        for side in range(-1, 2):
            bearing = pose[2] + beams[b, 1] + side * turn
            longest = max(longest, _expected_range(cells, x, y, bearing, range_max))
        if beams[b, 0] > longest + margin:
            count += 1
    return count
