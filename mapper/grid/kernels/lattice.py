"""Conversion from map coordinates to the grid's lattice, shared by array code and compiled kernels.

The functions work the same on floats, NumPy arrays and inside numba: :class:`mapper.grid.GridGeometry` calls them with
arrays, and the kernels compile them for scalars, so both round identically to the last bit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Frame(NamedTuple):
    """Pose of a lattice in the map: its corner, the direction of its columns' axis, and the side of a cell."""

    origin_x: float  #: m
    origin_y: float  #: m
    cos_yaw: float
    sin_yaw: float
    resolution: float  #: m


def to_lattice(
    x: Any,  # noqa: ANN401 - a float or an array of them, as the result
    y: Any,  # noqa: ANN401 - as above
    frame: Frame,
) -> tuple[Any, Any]:
    """Return lattice coordinates (u along columns, v along rows), in cells, of the map point (x, y) in metres.

    The lattice's axes are the map's rotated by the origin's yaw; its unit is one cell.
    """
    dx = x - frame.origin_x
    dy = y - frame.origin_y
    u = (frame.cos_yaw * dx + frame.sin_yaw * dy) / frame.resolution
    v = (frame.cos_yaw * dy - frame.sin_yaw * dx) / frame.resolution
    return u, v


def cell_of(coordinate: Any) -> Any:  # noqa: ANN401 - as above
    """Return the row or column (integral, but a float) that contains a lattice coordinate: its floor."""
    return np.floor(coordinate)
