"""What a model may have beside its layers: a recording, a comparison, a story. Routes ask for these, not for a kind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from mapper.grid import OccupancyGrid
from mapper.grid.compare import Comparison
from mapper.io.export import GrowingMap
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from server.sessions.view import LogView, Wanted

if TYPE_CHECKING:
    from mapper.diagnosis import Finding


class Recording(Protocol):
    """The log that a session shows."""

    log_id: str

    @property
    def log(self) -> ScanLog:
        """The log."""

    @property
    def trajectory(self) -> str:
        """The name of the trajectory in use."""

    def first_config(self) -> MappingConfig:
        """Return the parameters that the log is mapped with at first."""

    def view(self) -> LogView:
        """Return what is shown now."""

    async def growing_map(self) -> tuple[GrowingMap, str]:
        """Return how the map that is shown is made, and the name of its trajectory, between two ticks."""

    async def examined(self) -> list[Finding]:
        """Return what the doctor finds in the log with the present trajectory.

        Raises as :func:`mapper.diagnosis.examine`.
        """


class Comparable(Protocol):
    """The comparison of a session's map, B, with another one, A."""

    async def compare(self, wanted: Wanted | None) -> None:
        """Begin to compare with another map, or, None, end it. Raises :class:`mapper.core.errors.MapperError`."""

    async def compared(self) -> tuple[dict[str, Any], Comparison]:
        """Return A and the comparison, between two ticks. Raises :class:`mapper.core.errors.MapperError`."""

    def grids(self) -> tuple[OccupancyGrid, OccupancyGrid]:
        """Return the maps A and B, to be read while the session is still. Raises as :meth:`compared`."""

    def description(self) -> dict[str, Any] | None:
        """Return what A is, None where nothing is compared."""


class Story(Protocol):
    """The history of a session, from which it can be made again."""

    async def current(self) -> dict[str, Any]:
        """Return it as it is between two ticks."""
