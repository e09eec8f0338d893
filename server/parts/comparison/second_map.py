"""The second map of a comparison, of the session's log or of another one."""

from __future__ import annotations

from collections.abc import Callable

from mapper.core.errors import MapperError
from mapper.core.limits import Limits
from mapper.grid import OccupancyGrid
from mapper.grid.compare import Comparison, compare
from mapper.grid.merge import on_one_lattice
from mapper.io.logs.summary import recorded_seconds
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog
from mapper.simulation.second_map import SecondMap
from server.sessions.part import MappedScans
from server.sessions.view import Wanted
from server.stream.message_parts import Compared


class SecondMapView:
    """The second map of a log session. It has the same number of scans of the same log, or all scans of another log."""

    def __init__(
        self,
        wanted: Wanted,
        own: Replay,
        config: MappingConfig,
        limits: Limits,
        is_wanted: Callable[[], bool],
    ) -> None:
        """Make the map (worker thread). Raises as :class:`Replay` does."""
        self._wanted = wanted
        self._follows = wanted.log is None
        self._limits = limits
        log = wanted.log or own.log
        self.replay = Replay(log, config.with_values(wanted.values), wanted.trajectory, limits)
        self.replay.wanted = is_wanted
        self.replay.advance_to(own.index if self._follows else log.n_scans)
        self.second = SecondMap(wanted.values, True, self.replay.config, self.replay.grid)
        self.is_new = True  #: whether one of the two maps has changed since they were last compared
        self._recorded = recorded_seconds(log)

    def description(self) -> Compared:
        """The description of the map: ``compare`` of a ``parameters`` message."""
        wanted = self._wanted
        return Compared(
            values=wanted.values,
            with_faults=True,
            trajectory=self.replay.trajectory,
            log=None if self._follows else wanted.log_id,
            topic=wanted.topic,
            title=wanted.title,
        )

    def reconfigure(self, config: MappingConfig) -> None:
        """Recompute the map with the session's parameters, except its own. Raises as :meth:`Replay.reconfigure`."""
        beside = self.second.config_for(config)
        if beside != self.replay.config:
            self.replay.reconfigure(beside)
            self.second.begin(beside, self.replay.grid)

    def advance(self, index: int) -> None:
        """Go to the session's index in its log."""
        if not self._follows or index == self.replay.index:
            return
        grid = self.replay.grid
        change = self.replay.advance_to(index)
        if self.replay.grid is grid:
            self.second.add(change)
        else:
            self.second.begin(self.replay.config, self.replay.grid)

    def update_log(self, log: ScanLog) -> None:
        """Go on with the session's ``log``, the same scans with other trajectories. Raises as :class:`Replay` does."""
        old = self.replay
        if not self._follows or (old.trajectory in log.trajectories and old.adopt(log)):
            return
        if old.trajectory not in log.trajectories:
            return  # it was deleted: this map goes on with it
        replay = Replay(log, old.config, old.trajectory, self._limits)
        replay.wanted = old.wanted
        replay.advance_to(old.index)
        self.replay = replay
        self.second.begin(replay.config, replay.grid)

    def sources(self) -> list[MappedScans]:
        """The scans that are in the map."""
        return [MappedScans(self.replay.log, self.replay.trajectory, self.replay.index, self._recorded)]

    def compared(self, grid: OccupancyGrid) -> Comparison:
        """Compare with the session's map. Raises :class:`MapperError` if the two have no common lattice."""
        self.check_lattice(grid)
        return compare(self.replay.grid, grid)

    def check_lattice(self, grid: OccupancyGrid) -> None:
        """Raise :class:`MapperError` if this map and the session's have no common lattice."""
        try:
            on_one_lattice(self.replay.grid, grid)
        except MapperError as error:
            raise MapperError("compare.lattice", lattice_error(self.replay.grid, grid, error)) from error


def lattice_error(a: OccupancyGrid, b: OccupancyGrid, error: MapperError) -> str:
    """Return in one sentence why two maps cannot be compared cell by cell."""
    sizes = a.geometry.resolution, b.geometry.resolution
    if sizes[0] != sizes[1]:
        return f"A has cells of {sizes[0]:g} m and B of {sizes[1]:g} m: the cells do not coincide."
    return f"The two maps have no common lattice: {error.message}"
