"""The comparison of a log's map, B, with another map, A, which has its own layer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.grid import OccupancyGrid
from mapper.grid.compare import Comparison, compare
from mapper.grid.merge import on_one_lattice
from mapper.io.logs.summary import recorded_seconds
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog
from mapper.simulation.second_map import SecondMap
from server.parts.comparison.messages import ComparisonMessage
from server.sessions.hosting import ModelHost
from server.sessions.part import ExplainedMap, MappedScans, Part
from server.sessions.parts import Comparable, Recording
from server.sessions.tick import TickResult
from server.sessions.view import MapRequest
from server.stream.grid_layer import GridLayer
from server.stream.message_parts import Compared, Numbers
from server.stream.messages import ParametersMessage
from server.work.scheduler import checkpoint


def numbers(comparison: Comparison) -> Numbers:
    """Return the numbers of a comparison, rounded."""
    entropy_a, entropy_b = comparison.entropy_bits
    contrast_a, contrast_b = comparison.contrast
    at = comparison.max_at_xy
    return Numbers(
        cells=comparison.cells,
        states=comparison.states.tolist(),
        same=comparison.same,
        only=comparison.only,
        both=comparison.both,
        entropy_bits=(round(entropy_a, 1), round(entropy_b, 1)),
        contrast=(round(contrast_a, 4), round(contrast_b, 4)),
        mean_difference=round(comparison.mean_difference, 4),
        max_difference=round(comparison.max_difference, 4),
        max_at=None if at is None else (round(at[0], 4), round(at[1], 4)),
    )


def comparison_message(
    index: int, comparison: Comparison | None = None, refused: str | None = None
) -> ComparisonMessage:
    """Return a ``comparison`` message: the numbers, or the reason why the maps cannot be compared."""
    return ComparisonMessage(index, refused, None if comparison is None else numbers(comparison))


class LogComparison(Part, Comparable):
    """The second map of a log session, if there is one. ``message`` returns the ``parameters`` message."""

    def __init__(self, host: ModelHost, recording: Recording, message: Callable[[], ParametersMessage]) -> None:
        self._host, self._recording, self._message = host, recording, message
        self._other: SecondMapView | None = None
        self._layer: GridLayer | None = None
        self._request = 0  #: number of the newest request to compare; older ones are dropped

    # -- on the event loop --------------------------------------------------------------------------------------

    async def compare(self, requested: MapRequest | None) -> None:
        """Compare with another map, which replaces the previous one; None ends the comparison.

        Raises :class:`MapperError` if the other map cannot be computed or another one was requested in the meantime;
        the previous comparison then continues.
        """
        self._request += 1
        request = self._request
        other = None
        if requested is not None:
            # Computed while the session runs; _replace applies what has changed in the meantime.
            other = await self._host.on_thread(partial(self._second_view, requested, request))
        async with self._host.locked():
            if request != self._request or self._host.closed:
                raise _superseded()
            result = await self._host.on_thread(partial(self._replace, other))
        self._host.deliver(result)

    async def compared(self) -> tuple[Compared, Comparison]:
        """Return the description of A and the comparison, between ticks. Raises :class:`MapperError` without one."""
        async with self._host.settled():
            other = self._compared_with()
            result = await self._host.on_thread(partial(other.compared, self._recording.replay.grid))
            return other.description(), result

    def grids(self) -> tuple[OccupancyGrid, OccupancyGrid]:
        """Return the maps A and B, to be read while the session is locked. Raises like :meth:`compared`."""
        other, grid = self._compared_with(), self._recording.replay.grid
        other.check_lattice(grid)
        return other.replay.grid, grid

    def description(self) -> Compared | None:
        """Return the description of A, None if there is no comparison."""
        return None if self._other is None else self._other.description()

    def _compared_with(self) -> SecondMapView:
        if self._other is None:
            raise MapperError("compare.none", "This session has no comparison now.")
        return self._other

    # -- for the model --------------------------------------------------------------------------------------------

    @property
    def layers(self) -> tuple[GridLayer, ...]:
        """The layer of A, if there is one."""
        return () if self._layer is None else (self._layer,)

    @property
    def cells(self) -> int:
        """The cells of A."""
        return 0 if self._other is None else int(self._other.replay.grid.log_odds.size)

    @property
    def logs(self) -> tuple[ScanLog, ...]:
        """The log of A."""
        return () if self._other is None else (self._other.replay.log,)

    @property
    def has_deferred_work(self) -> bool:
        """Whether the numbers are out of date."""
        return self._other is not None and self._other.is_new

    def explained(self) -> list[ExplainedMap]:
        """Return A as a map whose cells can be explained."""
        other, layer = self._other, self._layer
        if other is None or layer is None:
            return []
        return [ExplainedMap(layer, other.replay.grid, other.replay.config, other.sources, other.replay.index)]

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def _second_view(self, requested: MapRequest, request: int) -> SecondMapView:
        def is_wanted() -> bool:
            checkpoint()
            return request == self._request and not self._host.closed

        limits, replay = self._host.limits(), self._recording.replay
        room = replace(limits, max_cells=max(1, limits.max_cells - int(replay.grid.log_odds.size)))
        try:
            return SecondMapView(requested, replay, replay.config, room, is_wanted)
        except WorkCancelledError as error:
            raise _superseded() from error

    def _replace(self, other: SecondMapView | None) -> TickResult:
        """Set another A, None for none; return what to send."""
        result = TickResult(changed=True)
        replay = self._recording.replay
        if other is None:
            self._other = self._layer = None
            result.slot(comparison_message(replay.index))
            result.slot(self._message())
            return result
        other.replay.may_continue = self._host.may_continue
        other.reconfigure(replay.config)
        other.advance(replay.index)
        other.second.changed()
        layer = GridLayer("second_map", "Second map")
        layer.update(other.second.grid, other.second.config, None, whole=True)
        self._other, self._layer = other, layer
        result.slot(self._message())
        return result

    def remake(self, before: MappingConfig, config: MappingConfig, result: TickResult) -> None:
        """Recompute both maps with other parameters, or neither. Raises like :meth:`Replay.reconfigure`."""
        other = self._other
        if other is not None:
            other.reconfigure(config)
        try:
            result.add(self._recording.replay.reconfigure(config))
        except MapperError:
            if other is not None:
                other.reconfigure(before)
            raise

    def update_log(self, log: ScanLog) -> None:
        """Continue with ``log``, the session's scans with other trajectories. Raises like :class:`Replay`."""
        if self._other is not None:
            self._other.update_log(log)

    def end(self, result: TickResult) -> None:
        """End the comparison, if any."""
        self._request += 1  # a comparison being prepared uses the previous log
        if self._other is not None:
            self._other = self._layer = None
            result.slot(comparison_message(self._recording.replay.index))

    def changed(self, result: TickResult) -> None:
        """Advance A to the session's scan, and update its layer."""
        other, layer = self._other, self._layer
        if other is None or layer is None:
            return
        other.advance(self._recording.replay.index)
        whole, box = other.second.changed()
        other.is_new |= whole or box is not None or result.new_grid or result.box is not None
        result.changed |= whole or box is not None
        result.changed |= layer.update(other.second.grid, other.second.config, box, whole=whole)

    def run_deferred_work(self, result: TickResult) -> None:
        """Compare the two maps, and send the numbers, if they are out of date."""
        other, replay = self._other, self._recording.replay
        if other is None or not other.is_new:
            return
        other.is_new = False
        try:
            result.slot(comparison_message(replay.index, other.compared(replay.grid)))
        except MapperError as error:
            result.slot(comparison_message(replay.index, refused=error.message))


def _superseded() -> MapperError:
    return MapperError("compare.superseded", "Another comparison was requested meanwhile; this one was dropped.")


class SecondMapView:
    """The second map of a log session. It has the same number of scans of the same log, or all scans of another log."""

    def __init__(
        self,
        requested: MapRequest,
        own: Replay,
        config: MappingConfig,
        limits: Limits,
        is_wanted: Callable[[], bool],
    ) -> None:
        """Compute the map (worker thread). Raises like :class:`Replay`."""
        self._wanted = requested
        self._follows = requested.log is None
        self._limits = limits
        log = requested.log or own.log
        self.replay = Replay(log, config.with_values(requested.values), requested.trajectory, limits)
        self.replay.may_continue = is_wanted
        self.replay.advance_to(own.index if self._follows else log.n_scans)
        self.second = SecondMap(requested.values, True, self.replay.config, self.replay.grid)
        self.is_new = True  #: whether one of the two maps has changed since the last comparison
        self._recorded = recorded_seconds(log)

    def description(self) -> Compared:
        """Description of the map: ``compare`` of a ``parameters`` message."""
        requested = self._wanted
        return Compared(
            values=requested.values,
            with_faults=True,
            trajectory=self.replay.trajectory,
            log=None if self._follows else requested.log_id,
            topic=requested.topic,
            title=requested.title,
        )

    def reconfigure(self, config: MappingConfig) -> None:
        """Recompute the map with the session's parameters, except its own. Raises like :meth:`Replay.reconfigure`."""
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
        """Continue with ``log``, the session's scans with other trajectories. Raises like :class:`Replay`."""
        old = self.replay
        if not self._follows or (old.trajectory in log.trajectories and old.adopt(log)):
            return
        if old.trajectory not in log.trajectories:
            return  # it was deleted; this map continues with it
        replay = Replay(log, old.config, old.trajectory, self._limits)
        replay.may_continue = old.may_continue
        replay.advance_to(old.index)
        self.replay = replay
        self.second.begin(replay.config, replay.grid)

    def sources(self) -> list[MappedScans]:
        """Return the scans in the map."""
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
    """Return one sentence that explains why two maps cannot be compared cell by cell."""
    sizes = a.geometry.resolution, b.geometry.resolution
    if sizes[0] != sizes[1]:
        return f"A has cells of {sizes[0]:g} m and B of {sizes[1]:g} m: the cells do not coincide."
    return f"The two maps have no common lattice: {error.message}"
