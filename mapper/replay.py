"""A log's map at any moment, with any parameters."""

from __future__ import annotations

from collections.abc import Callable

from mapper.errors import ConfigError, MapperError
from mapper.grid import OccupancyGrid
from mapper.integrate import CellBox, Change, geometry_for, grid_for, integrate_scans
from mapper.limits import DEFAULT_LIMITS, Limits
from mapper.parameters import MappingConfig
from mapper.provenance import Provenance, provenance
from mapper.scan import ScanLog

PART_READINGS = 1 << 22  #: readings that are added at once: a second's work or less


class UnwantedError(MapperError):
    """Nobody wants the map any more that was being made; its replay is of no use after that."""


class Replay:
    """The map of the first :attr:`index` scans of a log.

    The grid holds from the start all that the whole log will see, so it keeps its geometry while it is played. Not
    for several threads at once. With ``prior``, a map of the same place, mapping goes on from that, on its lattice.
    Raises as :func:`mapper.integrate.grid_for` does; after an error the replay is as
    it was before.
    """

    def __init__(
        self,
        log: ScanLog,
        config: MappingConfig | None = None,
        trajectory: str | None = None,
        limits: Limits = DEFAULT_LIMITS,
        prior: OccupancyGrid | None = None,
    ) -> None:
        self._limits = limits
        self._prior = prior
        self.log = log
        self.config = MappingConfig() if config is None else config
        self.trajectory = trajectory or log.default_trajectory
        self.grid = self._new_grid(log, self.config)
        self.index = 0  #: scans in the map
        self.wanted: Callable[[], bool] = lambda: True  #: asked now and then: False ends a long computation

    def _new_grid(self, log: ScanLog, config: MappingConfig) -> OccupancyGrid:
        return grid_for(log, config, self.trajectory, self._limits, self._prior)

    def advance_to(self, index: int) -> Change:
        """Bring the map to ``index`` scans: forwards by adding those between, backwards by making it anew.

        Raises :class:`ConfigError` for an index that the log does not have.
        """
        if not 0 <= index <= self.log.n_scans:
            raise ConfigError("replay.index", f"The log has {self.log.n_scans} scans; there is no map after {index}.")
        if index < self.index:
            # The whole grid is emptied, so all of it is what changed.
            emptied = self.grid.emptied()
            change = self._integrate(emptied, self.config, 0, index)
            rows, cols = emptied.geometry.shape
            self.grid, self.index = emptied, index
            return Change(CellBox(0, rows, 0, cols), geometry_changed=False, cells_updated=change.cells_updated)
        change = self._integrate(self.grid, self.config, self.index, index)
        self.index = index
        return change

    def reconfigure(self, config: MappingConfig) -> Change:
        """Make the whole map anew with other parameters, at the same index."""
        grid = self._new_grid(self.log, config)
        change = self._integrate(grid, config, 0, self.index)
        geometry_changed = grid.geometry != self.grid.geometry
        self.grid, self.config = grid, config
        rows, cols = grid.geometry.shape
        return Change(CellBox(0, rows, 0, cols), geometry_changed, change.cells_updated)

    def _integrate(self, grid: OccupancyGrid, config: MappingConfig, start: int, stop: int) -> Change:
        """As :func:`integrate_scans`, in parts between which :attr:`wanted` is asked. Raises :class:`UnwantedError`."""
        change = Change(None, geometry_changed=False, cells_updated=0)
        step = max(1, PART_READINGS // self.log.n_beams)
        for first in range(start, stop, step):
            if not self.wanted():
                raise UnwantedError("replay.unwanted", "The map is not wanted any more.")
            part = integrate_scans(grid, self.log, config, self.trajectory, first, min(first + step, stop))
            box = change.box | part.box if change.box is not None and part.box is not None else change.box or part.box
            change = Change(box, geometry_changed=False, cells_updated=change.cells_updated + part.cells_updated)
        return change

    def provenance(self, row: int, col: int) -> Provenance:
        """Return every beam that touched a cell of the map as it stands, with what it added.

        Raises :class:`ConfigError` for a cell outside the grid.
        """
        inside = self.grid.geometry.contains((row, col)) and self.grid.prior_map is not None
        prior = float(self.grid.prior()[row, col]) if inside else None
        return provenance(
            self.grid.geometry, self.log, self.config, (row, col), self.trajectory, self.index, prior=prior
        )

    def set_log(self, log: ScanLog) -> Change:
        """Go on with ``log``, which is the same log grown at its end; the map and the index stay.

        The grid grows to hold what the new scans see. Raises :class:`ConfigError` where the log is shorter than
        the map, has other beams or lacks the trajectory.
        """
        if log.n_scans < self.index or log.n_beams != self.log.n_beams:
            raise ConfigError(
                "replay.log",
                f"A log of {log.n_scans} scans × {log.n_beams} beams does not continue one of which {self.index} scans "
                f"× {self.log.n_beams} beams are in the map.",
            )
        needed = geometry_for(log, self.config, self.trajectory, self._limits)
        x, y, _ = needed.origin
        inside = 0.5 * needed.resolution
        high = (x + needed.cols * needed.resolution - inside, y + needed.rows * needed.resolution - inside)
        grown = self.grid.grow_to_include((x + inside, y + inside), high)
        self.log = log
        return Change(None, grown, 0)
