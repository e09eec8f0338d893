"""Map of a log at several times during its construction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OccupancyGrid
from mapper.io.maps import occupancy_values
from mapper.mapping.integrate import integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog

MOST_MAPS = 40
MOST_CELLS = 1 << 28  #: of all maps together: a large map is shown at fewer times
_BAND_CELLS = 1 << 18  # converted at once


@dataclass(frozen=True, slots=True)
class GrowingMap:
    """The map of a log's first scans, to be built again step by step.

    ``grid`` provides the geometry and the prior; its cells are not read. ``config`` is what it was made with, from the
    scans [0, ``n_scans``), None for the whole log.
    """

    grid: OccupancyGrid
    config: MappingConfig
    n_scans: int | None = None

    def maps(self, log: ScanLog, trajectory: str | None = None) -> Iterator[tuple[int, NDArray[np.int8]]]:
        """Yield (index of a scan, the map after it as :func:`mapper.io.maps.occupancy_values`), from first to last.

        There are at most :data:`MOST_MAPS` maps with at most :data:`MOST_CELLS` cells in total, but always the first
        and the last, evenly spaced in scans. The memory is that of one grid and one map. Without scans, the only map is
        the prior's. Raises the errors of :func:`mapper.mapping.integrate.integrate_log`.
        """
        grid = self.grid.emptied()
        stop = log.n_scans if self.n_scans is None else self.n_scans
        done = 0
        for last in scans_with_a_map(stop, grid.log_odds.size):
            integrate_log(grid, log, self.config, trajectory, done, last + 1)
            done = last + 1
            yield last, _values(grid)
        if stop == 0:
            yield 0, _values(grid)


def scans_with_a_map(n_scans: int, n_cells: int) -> list[int]:
    """Return the ascending indices of the scans, of ``n_scans``, after which a map of ``n_cells`` cells is written."""
    maps = min(n_scans, max(2, min(MOST_MAPS, MOST_CELLS // n_cells)))
    return sorted({int(index) for index in np.linspace(0, n_scans - 1, maps).round()}) if n_scans else []


def _values(grid: OccupancyGrid) -> NDArray[np.int8]:
    """Return :func:`occupancy_values` in bands, so that its float64 arrays have only a few rows."""
    rows, cols = grid.geometry.shape
    step = max(1, _BAND_CELLS // cols)
    out = np.empty((rows, cols), dtype=np.int8)
    for row in range(0, rows, step):
        part = slice(row, min(row + step, rows))
        band = OccupancyGrid(replace(grid.geometry, rows=part.stop - row))
        band.log_odds, band.observed = grid.log_odds[part], grid.observed[part]
        out[part] = occupancy_values(band)
    return out
