"""Second map of the same recording with other parameters, and how both maps forget removed objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.parameter import Values
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, CellBox, OccupancyGrid, probability
from mapper.mapping.integrate import Change
from mapper.mapping.parameters import MappingConfig
from mapper.simulation.edits import gone
from mapper.simulation.kernels.raycast import clearances
from mapper.simulation.shapes import Polygon
from mapper.simulation.worlds import World

MOST = 0.9  #: fraction of the cells that have to be free; cells that no beam crosses any more never change


def cells_of(grid: OccupancyGrid, solids: Sequence[Polygon], reach: float) -> NDArray[np.intp]:
    """Return the cells (n, 2), row and column, occupied in the map on ``solids`` or within ``reach`` metres."""
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
    """Tracks one map while it forgets: ``places`` (n, 2) are the centres of the watched cells, metres, map frame.

    ``free`` is the fraction of them that are free in the map after each scan, :attr:`after` the number of scans until
    :data:`MOST` of them were. Raises :class:`ConfigError` if there is nothing to forget.
    """

    places: NDArray[np.float64]
    free: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        if not len(self.places):
            raise ConfigError(
                "forgetting.nothing", "The object that was removed is not in the map: there is nothing to forget."
            )

    def look(self, grid: OccupancyGrid) -> None:
        """Record the fraction of free cells after one more scan."""
        rows, cols = np.moveaxis(grid.geometry.world_to_cell(self.places), -1, 0)
        self.free.append(float(np.mean(probability(grid.log_odds[rows, cols]) < FREE_THRESHOLD)))

    @property
    def after(self) -> int | None:
        """Number of scans until the map had forgotten; None if it has not."""
        return next((n for n, share in enumerate(self.free, 1) if share >= MOST), None)


@dataclass(slots=True)
class SecondMap:
    """A map with other ``values`` than the first, from true poses and readings, or ``with_faults`` of the first."""

    values: Values
    with_faults: bool
    config: MappingConfig
    grid: OccupancyGrid
    box: CellBox | None = None  #: box changed since the last call of :meth:`changed`; None: nothing
    is_new: bool = True  #: whether everything may have changed since then

    def config_for(self, config: MappingConfig) -> MappingConfig:
        """Return this map's parameters for the first map's ``config``. Raises the errors of ``with_values``."""
        return config.with_values(self.values)

    def begin(self, config: MappingConfig, grid: OccupancyGrid) -> None:
        """Continue with a recomputed map."""
        self.config, self.grid, self.is_new = config, grid, True

    def add(self, change: Change) -> None:
        """Merge the change of a scan."""
        self.is_new |= change.geometry_changed
        if change.box is not None:
            self.box = change.box if self.box is None else self.box | change.box

    def changed(self) -> tuple[bool, CellBox | None]:
        """Return whether everything, and otherwise which box, changed since the last call."""
        result = (self.is_new, self.box)
        self.is_new, self.box = False, None
        return result


@dataclass(slots=True)
class Vanishing:
    """Two maps, one clamped and one not, while they forget the same object."""

    clamped_first: bool  #: whether the session's own map is the clamped one
    first: Forgetting
    second: Forgetting

    @classmethod
    def of(cls, grid: OccupancyGrid, config: MappingConfig, before: World, after: World) -> Vanishing:
        """Start watching the cells of the solids missing in ``after``. Raises :class:`ConfigError` if the map has
        none.
        """
        cells = cells_of(grid, gone(before, after), config.resolution + 0.5 * config.window)
        places = grid.geometry.cell_to_world(cells).reshape(-1, 2)
        return cls(config.clamp, Forgetting(places), Forgetting(places))

    def look(self, first: OccupancyGrid, second: OccupancyGrid) -> None:
        """Record the fraction of free cells of both maps after one more scan."""
        self.first.look(first)
        self.second.look(second)
