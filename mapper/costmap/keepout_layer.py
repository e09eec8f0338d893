"""Keepout areas, painted or from a mask."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array, Int8Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.costs import NO_INFORMATION, name_of_cost
from mapper.costmap.kernels.observation import fill_polygon, lay_over
from mapper.costmap.layers import Robot, box_of, no_bounds, part_of
from mapper.costmap.masks import Mask, mask_costs
from mapper.costmap.parameters import COMBINATIONS
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry


class KeepoutLayer:
    """Keepout and high-cost areas (KeepoutFilter): a mask of values 0 to 100, −1 for none.

    Source: nav2_costmap_2d, keepout_filter.cpp: the mask's value is interpreted as a cost, and the greater cost is
    used.
    """

    def __init__(self, geometry: GridGeometry, mask: Mask | None = None, name: str = "keepout_filter") -> None:
        self.name = name
        self._geometry, self._bounds = geometry, no_bounds()
        self.mask: Int8Array = np.full(geometry.shape, -1, dtype=np.int8)
        if mask is not None:
            self.mask = mask.on(geometry)
            self._bounds[:] = 0, geometry.rows, 0, geometry.cols
        self.costs: UInt8Array = mask_costs(self.mask)

    def paint(self, polygon_xy: Float64Array, value: int) -> None:
        """Set the mask's value in the cells of a polygon (n, 2), map metres; −1 erases.

        Raises :class:`ConfigError` for a value outside −1 … 100 or a polygon of fewer than three points.
        """
        vertices = np.asarray(polygon_xy, dtype=np.float64)
        if vertices.ndim != 2 or vertices.shape[0] < 3 or vertices.shape[1] != 2 or not np.isfinite(vertices).all():
            raise ConfigError("costmap.polygon", "A painted area must be a polygon of at least three finite points.")
        if not -1 <= value <= 100:
            raise ConfigError("costmap.mask_value", f"A mask’s value must be −1 … 100, not {value}.")
        cost = mask_costs(np.array([value], dtype=np.int8))[0]
        lattice = self._geometry.to_lattice(vertices)
        fill_polygon(lattice, np.int8(value), self.mask, self._bounds)
        fill_polygon(lattice, cost, self.costs, self._bounds)

    def clear(self) -> None:
        """Remove everything painted."""
        painted = np.argwhere(self.mask >= 0)
        if len(painted):
            (row0, col0), (row1, col1) = painted.min(axis=0), painted.max(axis=0)
            bounds = self._bounds
            bounds[0], bounds[1] = min(bounds[0], row0), max(bounds[1], row1 + 1)
            bounds[2], bounds[3] = min(bounds[2], col0), max(bounds[3], col1 + 1)
            self.mask[...], self.costs[...] = -1, NO_INFORMATION

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Return the box painted since the last call."""
        del now, robot
        box, self._bounds = box_of(self._bounds), no_bounds()
        return box

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Keep the greater of both costs."""
        lay_over(self.costs[part_of(box)], COMBINATIONS.index("max"), master[part_of(box)])

    def why(self, row: int, col: int) -> str:
        """Describe the painted value."""
        value = int(self.mask[row, col])
        if value < 0:
            return "Nothing is painted here."
        return f"Painted with {value} of 100: {name_of_cost(int(self.costs[row, col]))}."
