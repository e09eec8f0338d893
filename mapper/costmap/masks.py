"""Masks of Nav2's costmap filters: maps with values 0 to 100 that are not occupancy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from mapper.core.array_types import Int8Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.costs import LETHAL, NO_INFORMATION
from mapper.grid.occupancy_grid import GridGeometry

Values = TypeVar("Values", Int8Array, UInt8Array)


@dataclass(frozen=True, slots=True)
class Mask:
    """Values (rows, cols) int8, 0 to 100 or −1 for none, over the cells of a separate geometry.

    ``notes`` are those of the reader of its file. Raises :class:`ConfigError` for another shape.
    """

    geometry: GridGeometry
    values: Int8Array
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.values.shape != self.geometry.shape:
            raise ConfigError(
                "costmap.mask", f"The mask has {self.values.shape} values for {self.geometry.shape} cells."
            )

    def at(self, x: float, y: float) -> int | None:
        """Return the value at a point in map metres, or None outside the mask (CostmapFilter::worldToMask)."""
        row, col = (int(index) for index in self.geometry.world_to_cell((x, y)))
        rows, cols = self.geometry.shape
        return int(self.values[row, col]) if 0 <= row < rows and 0 <= col < cols else None

    def on(self, geometry: GridGeometry) -> Int8Array:
        """Return the values (rows, cols) at the cells' centres of another geometry; −1 outside the mask."""
        return on_geometry(self.values, self.geometry, geometry, -1)


def on_geometry(values: Values, own: GridGeometry, geometry: GridGeometry, outside: int) -> Values:
    """Sample values (rows, cols) of the geometry ``own`` at the cell centres of another geometry."""
    if geometry == own:
        return values.copy()
    out = np.full(geometry.shape, outside, dtype=values.dtype)
    cols = np.arange(geometry.cols)
    for row in range(geometry.rows):
        at = own.world_to_cell(geometry.cell_to_world(np.column_stack([np.full_like(cols, row), cols])))
        is_inside = ((at >= 0) & (at < own.shape)).all(axis=1)
        out[row, is_inside] = values[at[is_inside, 0], at[is_inside, 1]]
    return out


def mask_costs(values: Int8Array) -> UInt8Array:
    """Return the costs uint8 of a keepout mask's values; −1 becomes NO_INFORMATION (CostmapFilter::getMaskCost)."""
    # std::round rounds halves away from zero; np.rint rounds them to even.
    scaled = np.floor(values.astype(np.float64) * LETHAL / 100.0 + 0.5)
    return np.where(values < 0, NO_INFORMATION, scaled).astype(np.uint8)
