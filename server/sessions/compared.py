"""A session whose map can be compared with another one, which watchers are sent beside it."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from functools import partial
from typing import Any

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.grid import OccupancyGrid
from mapper.grid.compare import Comparison
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog
from server.sessions.second_map_view import SecondMapView, Wanted, comparison_message
from server.sessions.session import Session
from server.sessions.tick import TickResult
from server.sessions.view import Side
from server.stream.layers import GridLayer, Layer
from server.work.scheduler import checkpoint


class ComparableSession(Session):
    """A session of a replay, B, with another side beside it, A, where somebody compares."""

    _other: SecondMapView | None = None
    _second_layer: GridLayer | None = None  #: shows A
    _wish = 0  #: counts the wishes to compare: only the newest is fulfilled

    @property
    @abstractmethod
    def replay(self) -> Replay:
        """What the session's map is made by."""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The map, and the other side where there is one."""
        return (self.map_layer,) if self._second_layer is None else (self.map_layer, self._second_layer)

    @property
    def cells(self) -> int:
        """Cells of the session's grids."""
        other = self._other
        return super().cells + (0 if other is None else int(other.replay.grid.log_odds.size))

    @property
    def logs(self) -> tuple[ScanLog, ...]:
        """The logs that the session holds in memory."""
        return (self.replay.log,) if self._other is None else (self.replay.log, self._other.replay.log)

    # -- for everybody on the event loop --------------------------------------------------------------------------

    async def compare(self, wanted: Wanted | None) -> None:
        """Begin to compare with another map, or, None, end it; what was compared before ends.

        Raises :class:`MapperError` where the other map cannot be made, or somebody wished for another one meanwhile;
        what was compared before goes on then.
        """
        self._wish += 1
        wish = self._wish
        other = None
        if wanted is not None:
            # Made while the session goes on; what has changed meanwhile is made up for when it is taken over.
            other = await self.on_thread(partial(self._other_side, wanted, wish))
        async with self._lock:
            if wish != self._wish or self.closed:
                raise _superseded()
            outcome = await self.on_thread(partial(self._take_over, other))
        self._deliver(outcome)
        self._wake.set()

    async def compared(self) -> tuple[dict[str, Any], Comparison]:
        """Return what is compared with, and how, between two ticks. Raises :class:`MapperError` where it cannot be."""
        async with self._lock:
            other = self._compared_with()
            found = await self.on_thread(partial(other.compared, self.grid))
            return other.description(), found

    def compared_grids(self) -> tuple[OccupancyGrid, OccupancyGrid]:
        """Return the maps A and B, to be read while the session is :meth:`still`. Raises as :meth:`compared`."""
        other = self._compared_with()
        other.check_lattice(self.grid)
        return other.replay.grid, self.grid

    def _compared_with(self) -> SecondMapView:
        if self._other is None:
            raise MapperError("compare.none", "This session compares its map with no other one now.")
        return self._other

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def _other_side(self, wanted: Wanted, wish: int) -> SecondMapView:
        def is_wanted() -> bool:
            checkpoint()
            return wish == self._wish and not self.closed

        limits = self.limits()
        room = replace(limits, max_cells=max(1, limits.max_cells - int(self.grid.log_odds.size)))
        try:
            return SecondMapView(wanted, self.replay, self.config, room, is_wanted)
        except WorkCancelledError as error:
            raise _superseded() from error

    def _take_over(self, other: SecondMapView | None) -> TickResult:
        """Go on with another other side, in a layer of its own; return what to send."""
        outcome = TickResult(changed=True)
        if other is None:
            self._other = self._second_layer = None
            outcome.slot(comparison_message(self.replay.index))
            outcome.slot(self.parameters_message())
            return outcome
        other.replay.wanted = self.goes_on
        other.follow(self.config)
        other.advance(self.replay.index)
        other.second.changed()
        layer = GridLayer("second_map", "Second map")
        layer.update(other.second.grid, other.second.config, None, whole=True)
        self._other, self._second_layer = other, layer
        outcome.slot(self.parameters_message())
        return outcome

    def follow(self, config: MappingConfig, outcome: TickResult) -> None:
        """Make both maps anew with other parameters, or neither. Raises as :meth:`Replay.reconfigure`."""
        other, before = self._other, self.config
        if other is not None:
            other.follow(config)
        try:
            outcome.add(self.replay.reconfigure(config))
        except MapperError:
            if other is not None:
                other.follow(before)
            raise

    def draw_second(self, outcome: TickResult) -> None:
        """Bring the other side, and its layer, to where the session is."""
        other, layer = self._other, self._second_layer
        if other is None or layer is None:
            return
        other.advance(self.replay.index)
        whole, box = other.second.changed()
        other.is_new |= whole or box is not None or outcome.new_grid or outcome.box is not None
        outcome.changed |= whole or box is not None
        outcome.changed |= layer.update(other.second.grid, other.second.config, box, whole=whole)

    @property
    def has_deferred_work(self) -> bool:
        """Whether the numbers are older than the maps."""
        return self._other is not None and self._other.is_new

    def run_deferred_work(self, outcome: TickResult) -> None:
        """Compare the two maps as they are."""
        other, index = self._other, self.replay.index
        if other is None:
            return
        other.is_new = False
        try:
            outcome.slot(comparison_message(index, other.compared(self.grid)))
        except MapperError as error:
            outcome.slot(comparison_message(index, refused=error.message))

    def parameters_message(self) -> dict[str, Any]:
        """As every session's, with what the map is compared with."""
        other = self._other
        return super().parameters_message() | {"compare": None if other is None else other.description()}

    def side(self, layer: str) -> Side:
        """As every session's, and the other side where there is one."""
        other, shown = self._other, self._second_layer
        if other is None or shown is None or layer != shown.name:
            return super().side(layer)
        return Side(other.replay.grid, other.replay.config, other.sources, other.replay.index, shown)


def _superseded() -> MapperError:
    return MapperError("compare.superseded", "Somebody wished for another comparison meanwhile; this one was dropped.")
