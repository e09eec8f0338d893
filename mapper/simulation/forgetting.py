"""Number of scans until the cells of a removed object are free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, OccupancyGrid, probability
from mapper.simulation.kernels.raycast import clearances
from mapper.simulation.shapes import Polygon

MOST = 0.9  #: share of the cells that have to be free: a cell that no beam crosses any more never changes


def cells_of(grid: OccupancyGrid, solids: Sequence[Polygon], reach: float) -> NDArray[np.intp]:
    """Return the cells (n, 2), row and column, that the map holds occupied on ``solids`` or within ``reach`` metres."""
    if not solids:
        return np.empty((0, 2), dtype=np.intp)
    edges = [np.hstack([solid, np.roll(solid, -1, axis=0)]) for solid in solids]
    occupied = np.argwhere(grid.observed & (probability(grid.log_odds) > OCCUPIED_THRESHOLD))
    distance = np.empty(len(occupied))
    clearances(
        np.ascontiguousarray(np.vstack(edges)), np.ascontiguousarray(grid.geometry.cell_to_world(occupied)), distance
    )
    return occupied[distance <= reach]


@dataclass(slots=True)
class Forgetting:
    """Follows one map while it forgets: ``places`` (n, 2) are the centres of the cells to watch, metres, map frame.

    ``free`` is the share of them that the map holds free after each scan, :attr:`after` the number of scans until
    :data:`MOST` of them were. Raises :class:`ConfigError` where there is nothing to forget.
    """

    places: NDArray[np.float64]
    free: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        if not len(self.places):
            raise ConfigError("forgetting.nothing", "The map has not seen what was taken away: nothing to forget.")

    def look(self, grid: OccupancyGrid) -> None:
        """Record the share of free cells after one more scan."""
        rows, cols = np.moveaxis(grid.geometry.world_to_cell(self.places), -1, 0)
        self.free.append(float(np.mean(probability(grid.log_odds[rows, cols]) < FREE_THRESHOLD)))

    @property
    def after(self) -> int | None:
        """Scans until the map had forgotten, None while it has not."""
        return next((n for n, share in enumerate(self.free, 1) if share >= MOST), None)
