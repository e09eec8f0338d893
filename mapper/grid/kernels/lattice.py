"""The one formula from map coordinates to the grid's lattice, written once for arrays and for compiled kernels.

Plain Python that means the same on floats, on NumPy arrays and inside numba: :class:`mapper.grid.GridGeometry` calls
these two with arrays, the kernels compile them for scalars, so both round alike to the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def to_lattice(
    x: Any,  # noqa: ANN401 - a float or an array of them, and the like comes back
    y: Any,  # noqa: ANN401 - as above
    origin_x: float,
    origin_y: float,
    cos_yaw: float,
    sin_yaw: float,
    resolution: float,
) -> tuple[Any, Any]:
    """Return lattice coordinates (u along columns, v along rows), in cells, of the map point (x, y) in metres.

    The lattice's axes are the map's turned by the origin's yaw; its unit is one cell.
    """
    dx = x - origin_x
    dy = y - origin_y
    return (cos_yaw * dx + sin_yaw * dy) / resolution, (cos_yaw * dy - sin_yaw * dx) / resolution


def cell_of(coordinate: Any) -> Any:  # noqa: ANN401 - as above
    """Return the row or column (a whole number, still a float) that holds a lattice coordinate: its floor."""
    return np.floor(coordinate)
