"""A second map of the same recording, with other parameters; and how both forget what was removed."""

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
            raise ConfigError(
                "forgetting.nothing", "The object that was removed is not in the map: there is nothing to forget."
            )

    def look(self, grid: OccupancyGrid) -> None:
        """Record the share of free cells after one more scan."""
        rows, cols = np.moveaxis(grid.geometry.world_to_cell(self.places), -1, 0)
        self.free.append(float(np.mean(probability(grid.log_odds[rows, cols]) < FREE_THRESHOLD)))

    @property
    def after(self) -> int | None:
        """Scans until the map had forgotten, None while it has not."""
        return next((n for n, share in enumerate(self.free, 1) if share >= MOST), None)


@dataclass(slots=True)
class SecondMap:
    """A map with other ``values`` than the first, of true poses and readings, or ``with_faults`` of the first."""

    values: Values
    with_faults: bool
    config: MappingConfig
    grid: OccupancyGrid
    box: CellBox | None = None  #: what changed since the last call of :meth:`changed`; None: nothing
    is_new: bool = True  #: whether everything may have changed since then

    def config_for(self, config: MappingConfig) -> MappingConfig:
        """Return this map's parameters when the first one's are ``config``. Raises as ``with_values`` does."""
        return config.with_values(self.values)

    def begin(self, config: MappingConfig, grid: OccupancyGrid) -> None:
        """Go on with a map that was made again."""
        self.config, self.grid, self.is_new = config, grid, True

    def add(self, change: Change) -> None:
        """Take up what a scan changed."""
        self.is_new |= change.geometry_changed
        if change.box is not None:
            self.box = change.box if self.box is None else self.box | change.box

    def changed(self) -> tuple[bool, CellBox | None]:
        """Return whether all, and else which box, changed since the last call."""
        result = (self.is_new, self.box)
        self.is_new, self.box = False, None
        return result


@dataclass(slots=True)
class Vanishing:
    """Two maps, one clamped and one not, while they forget the same thing."""

    clamped_first: bool  #: whether the session's own map is the clamped one
    first: Forgetting
    second: Forgetting

    @classmethod
    def of(cls, grid: OccupancyGrid, config: MappingConfig, before: World, after: World) -> Vanishing:
        """Begin to watch the cells of what ``after`` lacks. Raises :class:`ConfigError` where the map holds none."""
        cells = cells_of(grid, gone(before, after), config.resolution + 0.5 * config.window)
        places = grid.geometry.cell_to_world(cells).reshape(-1, 2)
        return cls(config.clamp, Forgetting(places), Forgetting(places))

    def look(self, first: OccupancyGrid, second: OccupancyGrid) -> None:
        """Record the share of free cells of both maps after one more scan."""
        self.first.look(first)
        self.second.look(second)
