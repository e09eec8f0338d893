"""Test of which points mark a cell, and bounding box of written cells.

Plain Python functions: each module of kernels compiles its own copies.
"""

from __future__ import annotations

from typing import NamedTuple

from mapper.core.array_types import Float64Array, Int64Array


class Marking(NamedTuple):
    """Limits for points that mark: distance from the sensor and height, metres."""

    obstacle_min_range: float
    obstacle_max_range: float
    min_obstacle_height: float
    max_obstacle_height: float


def include(box: Int64Array, row: int, col: int) -> None:
    """Extend a box (row0, row1, col0, col1) to contain a cell."""
    box[0], box[1] = min(box[0], row), max(box[1], row + 1)
    box[2], box[3] = min(box[2], col), max(box[3], col + 1)


def marks(point: Float64Array, sensor: Float64Array, marking: Marking) -> bool:
    """Return whether a point (3,) is within the heights and the distances from the sensor (3,) that mark."""
    if not marking.min_obstacle_height <= point[2] <= marking.max_obstacle_height:
        return False
    d_x, d_y, d_z = point[0] - sensor[0], point[1] - sensor[1], point[2] - sensor[2]
    squared: float = d_x * d_x + d_y * d_y + d_z * d_z
    return marking.obstacle_min_range**2 <= squared < marking.obstacle_max_range**2
