"""A part of a session: one capability, as the model and its host see it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

from msgspec import Struct

from mapper.core.array_types import BoolArray, Float64Array
from mapper.grid import OccupancyGrid
from server.sessions.drawings import Drawing
from server.sessions.hosting import ModelHost
from server.sessions.parts import LayerCosts
from server.sessions.tick import TickResult
from server.stream.layers import Layer

#: A hexagon around the lab's robot, whose radius is 0.2 m: corners in its frame, metres.
HEXAGON = ((0.231, 0.0), (0.1155, 0.2), (-0.1155, 0.2), (-0.231, 0.0), (-0.1155, -0.2), (0.1155, -0.2))


class Cloud(Protocol):
    """Points that a source offers."""

    @property
    def count(self) -> int:
        """Number of scans; 0 without points."""

    @property
    def truth(self) -> str | None:
        """Source of known ground points, None if there is none."""

    def points(self) -> Float64Array:
        """Return the points (n, 3) alone."""

    def read(self) -> tuple[Float64Array, tuple[float, float, float, float], BoolArray | None]:
        """Return points (n, 3), the bounds x0, y0, x1, y1, and which points are ground, None if that is not known."""


class Part:
    """A capability of a session. Each method has a default, and runs on a worker thread unless stated otherwise."""

    commands: ClassVar[tuple[type[Struct], ...]] = ()  #: those that :meth:`handle` takes
    subject: ClassVar[str] = "map"  #: what it computes, as in the message ``working``
    tables: Mapping[str, list[dict[str, Any]]] = {}  #: rows of its parameters, by the field of ``hello`` that has them

    @property
    def layers(self) -> Sequence[Layer]:
        """Its layers; none while it is off."""
        return ()

    @property
    def cells(self) -> int:
        """Cells of the grids that it holds, or numbers of 4 bytes (any thread)."""
        return 0

    @property
    def progress(self) -> float | None:
        """The share of its present computation that is done, 0 to 1; None while it computes nothing (any thread)."""
        return None

    @property
    def is_behind(self) -> bool:
        """Whether it has not done yet what commands requested: the next tick goes on (event loop)."""
        return False

    def messages(self) -> list[dict[str, Any]]:
        """Return the messages for a new client: the newest of each type."""
        return []

    def handle(self, command: Any, result: TickResult) -> None:  # noqa: ANN401 - one of the part's own commands
        """Carry out one of :attr:`commands`. Raises as :meth:`server.sessions.model.SessionModel.handle`."""

    def note(self, command: Struct, result: TickResult) -> None:
        """Take note of a command that the source has carried out, such as another world."""

    def changed(self, result: TickResult) -> None:
        """Follow what changed in the source in this tick: ``result`` has the cells of its map. Update the layers."""

    def drawings(self) -> list[Drawing]:
        """Return what it shows in 3D (event loop, between two ticks)."""
        return []


@dataclass(slots=True)
class Offers:
    """What a source offers its parts, and what earlier parts offer later ones; what there is not is None or left out.

    ``maps`` are maps beside the source's own by name: another object when one has changed, None while it is off;
    ``costs`` are costs of a layer of a costmap by the layer's name, in the same way.
    """

    host: ModelHost
    cloud: Cloud | None = None
    maps: dict[str, Callable[[], OccupancyGrid | None]] = field(default_factory=dict)
    costs: dict[str, Callable[[], LayerCosts | None]] = field(default_factory=dict)
