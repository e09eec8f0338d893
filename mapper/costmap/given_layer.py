"""Layer with costs computed by another module, such as those of a terrain."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.costs import NO_INFORMATION, name_of_cost
from mapper.costmap.kernels.observation import lay_over
from mapper.costmap.layers import Robot, part_of
from mapper.costmap.masks import on_geometry
from mapper.costmap.parameters import COMBINATIONS
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry


class GivenLayer:
    """Externally set costs (rows, cols) uint8; the greater of these and the costs before is used.

    ``reason`` returns one sentence on the cost of a cell (row, col). Cells are 255 until they are set.
    """

    def __init__(self, geometry: GridGeometry, name: str, reason: Callable[[int, int], str] | None = None) -> None:
        self.name = name
        self.costs: UInt8Array = np.full(geometry.shape, NO_INFORMATION, dtype=np.uint8)
        self._geometry, self._reason = geometry, reason
        self._changed: CellBox | None = None

    def set(self, costs: UInt8Array, row: int = 0, col: int = 0) -> None:
        """Set the costs of a rectangle with its first cell at (row, col).

        Raises :class:`ConfigError` for another type than uint8, and for a rectangle outside the layer.
        """
        if costs.dtype != np.uint8 or costs.ndim != 2:
            raise ConfigError("costmap.given", f"Costs must be a uint8 array (rows, cols), not {costs.dtype}.")
        rows, cols = costs.shape
        if not (0 <= row <= self.costs.shape[0] - rows and 0 <= col <= self.costs.shape[1] - cols):
            raise ConfigError(
                "costmap.shape",
                f"The costs {costs.shape} at ({row}, {col}) are not within the {self.costs.shape} cells of "
                f"{self.name!r}.",
            )
        if costs.size == 0:
            return
        self.costs[row : row + rows, col : col + cols] = costs
        box = CellBox(row, row + rows, col, col + cols)
        self._changed = box if self._changed is None else self._changed | box

    def take(self, costs: UInt8Array, geometry: GridGeometry) -> None:
        """Set all costs by sampling those (rows, cols) of another geometry at the centres of the layer's cells.

        Cells outside it are 255. Raises :class:`ConfigError` for another shape than the geometry's.
        """
        if costs.shape != geometry.shape:
            raise ConfigError("costmap.shape", f"The costs {costs.shape} do not fit their {geometry.shape} cells.")
        self.set(on_geometry(costs, geometry, self._geometry, NO_INFORMATION))

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Return the box set since the last call."""
        del now, robot
        box, self._changed = self._changed, None
        return box

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Keep the greater of both costs."""
        lay_over(self.costs[part_of(box)], COMBINATIONS.index("max"), master[part_of(box)])

    def why(self, row: int, col: int) -> str:
        """Describe the cost, with the given reason if there is one."""
        if self._reason is not None:
            return self._reason(row, col)
        return f"Given: {name_of_cost(int(self.costs[row, col]))}."
