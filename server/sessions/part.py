"""A part of a session: the interface of one capability for its source and the host, and what a source offers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from msgspec import Struct

from mapper.core.array_types import BoolArray, Float64Array, Int8Array
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import RangeScan, ScanLog
from server.sessions.drawings import Drawing
from server.sessions.hosting import ModelHost
from server.sessions.parts import Costing, LayerCosts, Recording
from server.sessions.tick import TickResult
from server.sessions.view import Playback, Pose
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import Parameter

if TYPE_CHECKING:
    from mapper.simulation.live_map import LiveMap
    from server.library.packs.reference_map import ReferenceMap


class Cloud(Protocol):
    """Points that a source offers."""

    @property
    def count(self) -> int:
        """Number of scans; 0 without points."""

    @property
    def truth(self) -> str | None:
        """Source of the known ground points, None if there is none."""

    def points(self) -> Float64Array:
        """Return only the points (n, 3)."""

    def read(self) -> tuple[Float64Array, tuple[float, float, float, float], BoolArray | None]:
        """Return points (n, 3), the bounds x0, y0, x1, y1, and which points are ground, None if unknown."""


@dataclass(frozen=True, slots=True)
class Robot:
    """The current robot of a source, in its map.

    ``pose`` is the robot's own estimate of T_map_base, ``time_s`` the time on the clock of its scans. ``scan`` is its
    newest scan, None while that is not in the map, and ``scan_pose`` its T_map_laser. ``number`` increases with each
    new scan and decreases when the map goes back to an earlier one. ``topic`` is the topic of the scan; ``topics`` are
    all topics of mapped scans. They are empty if there are none.
    """

    pose: Pose
    time_s: float
    scan: RangeScan | None
    scan_pose: Pose | Float64Array
    number: int
    topic: str = ""
    topics: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class MappedScans:
    """Scans in a map: the first ``stop`` scans of a log, with one of its trajectories."""

    log: ScanLog
    trajectory: str
    stop: int
    stamps_s: Float64Array  #: (n_scans,), as in the ``frame`` message


@dataclass(frozen=True, slots=True)
class ExplainedMap:
    """A map whose cells can be explained: its layer, and the logs of the ``index`` scans in it."""

    layer: GridLayer
    grid: OccupancyGrid
    config: MappingConfig
    scans: Callable[[], Sequence[MappedScans]]
    index: int


@dataclass(frozen=True, slots=True, eq=False)
class StaticMap:
    """A map that does not change by itself.

    ``keepout`` and ``speed`` (rows, cols) int8 are its masks of keepout zones and of speed limits, 0 to 100.
    """

    grid: OccupancyGrid
    keepout: Int8Array | None = None
    speed: Int8Array | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """A static map in addition to the source's own.

    ``title`` completes "Which map: …". ``read`` returns the map, and raises :class:`mapper.core.errors.ConfigError` if
    there is none. ``version`` returns another object when the map is another one. ``is_first`` says whether the current
    poses are in this map, which makes it the initial choice.
    """

    title: str
    read: Callable[[], StaticMap]
    version: Callable[[], object] = lambda: None
    is_first: Callable[[], bool] = lambda: False


@dataclass(frozen=True, slots=True)
class OtherMap:
    """A changing map in addition to the source's own.

    ``read`` returns another object when the map has changed, None while there is none. ``title`` is like a plan's.
    """

    title: str
    read: Callable[[], OccupancyGrid | None]


@dataclass(slots=True)
class Offers:
    """What a source offers its parts, and earlier parts later ones. What is not available is None or left out.

    ``grid`` returns the source's map, described by ``map_title`` (like the title of a plan), and ``robot`` the robot in
    it. ``drive`` drives the robot with velocities in m/s and rad/s. ``plans`` and ``maps`` are other maps by name.
    ``costs`` are costs for a costmap layer by the layer's name: another object when they have changed, None while there
    are none. ``costing`` has the costs on which a path is planned.

    ``map`` is a map of the library that is shown by itself. ``explained`` returns the maps whose cells can be
    explained, the default first. ``recording`` is the log being played; ``update_log`` replaces it by one with other
    trajectories. ``simulation`` is the simulated world with its robot.
    """

    host: ModelHost
    cloud: Cloud | None = None
    grid: Callable[[], OccupancyGrid] | None = None
    map_title: str = ""
    robot: Callable[[], Robot] | None = None
    drive: Callable[[float, float, TickResult], None] | None = None
    plans: dict[str, Plan] = field(default_factory=dict)
    maps: dict[str, OtherMap] = field(default_factory=dict)
    costs: dict[str, Callable[[], LayerCosts | None]] = field(default_factory=dict)
    costing: Costing | None = None
    map: ReferenceMap | None = None
    explained: Callable[[], Sequence[ExplainedMap]] | None = None
    recording: Recording | None = None
    update_log: Callable[[ScanLog, TickResult], None] | None = None
    simulation: LiveMap | None = None
    playback: Playback = field(default_factory=Playback)


class Part:
    """A capability of a session. All methods have defaults, and run on a worker thread unless stated otherwise."""

    commands: ClassVar[tuple[type[Struct], ...]] = ()  #: those that :meth:`handle` accepts
    recorded: ClassVar[tuple[type[Struct], ...]] = ()  #: those of them that :meth:`history` may return
    subject: ClassVar[str] = "map"  #: what it computes, as in the ``working`` message
    #: Whether it has anything to show or to follow. A part that is off, as many are most of the time, only receives
    #: commands and calls of :meth:`messages`, :meth:`history` and :meth:`forget`.
    is_on: bool = True
    followed: Costing | None = None  #: a part whose results it uses; while that part is on, this one is called too
    tables: Mapping[str, list[Parameter]] = {}  #: rows of its parameters, by the type of the command that sets them

    @property
    def layers(self) -> Sequence[Layer]:
        """Its layers."""
        return ()

    @property
    def cells(self) -> int:
        """Number of cells of its grids, or of 4-byte values (any thread)."""
        return 0

    @property
    def progress(self) -> float | None:
        """Completed share of its current computation, 0 to 1; None while it computes nothing (any thread)."""
        return None

    @property
    def is_behind(self) -> bool:
        """Whether requested work is not done yet, so that the next tick continues (event loop)."""
        return False

    @property
    def answering(self) -> str:
        """Subject of an answer that is computed outside the ticks, "" for none (any thread)."""
        return ""

    @property
    def hint(self) -> str:
        """Effect of a click in the 3D view if this part handles it, otherwise "" (event loop)."""
        return ""

    @property
    def logs(self) -> Sequence[ScanLog]:
        """Logs that it uses in addition to the source's (any thread)."""
        return ()

    @property
    def has_deferred_work(self) -> bool:
        """Whether there is work that its layers do not depend on (event loop)."""
        return False

    def run_deferred_work(self, result: TickResult) -> None:
        """Do the deferred work, if any."""

    def messages(self) -> Sequence[Struct]:
        """Return the messages for a new client: the newest of each type."""
        return ()

    def history(self) -> Sequence[Struct]:
        """Return the commands that bring another session to the same state; none while it is off."""
        return ()

    def handle(self, command: Any, result: TickResult) -> None:  # noqa: ANN401 - one of the part's own commands
        """Carry out one of :attr:`commands`. Raises like :meth:`server.sessions.model.SessionModel.handle`."""

    def note(self, command: Struct, result: TickResult) -> None:
        """Follow a command that the source has carried out, such as a change of the world."""

    def advance(self, seconds: float, result: TickResult) -> float:  # noqa: ARG002 - most parts do not drive
        """Act before simulated time passes. Return after how many of the ``seconds`` to call this again."""
        return seconds

    def changed(self, result: TickResult) -> None:
        """Follow the source's changes in this tick (``result`` has the changed map cells), and update the layers."""

    def forget(self) -> None:
        """Reload what depends on the log's trajectories, because one of them was replaced."""

    def over(self, flat: list[Drawing]) -> list[Drawing]:
        """Return the source's drawings without those that this part replaces (event loop, between two ticks)."""
        return flat

    def drawings(self) -> list[Drawing]:
        """Return its drawings for the 3D view (event loop, between two ticks)."""
        return []
