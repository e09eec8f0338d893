"""A part of a session: one capability, as its source and the host see it, and what a source offers its parts."""

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
        """Source of known ground points, None if there is none."""

    def points(self) -> Float64Array:
        """Return the points (n, 3) alone."""

    def read(self) -> tuple[Float64Array, tuple[float, float, float, float], BoolArray | None]:
        """Return points (n, 3), the bounds x0, y0, x1, y1, and which points are ground, None if that is not known."""


@dataclass(frozen=True, slots=True)
class Robot:
    """The robot of a source now, in its map.

    ``pose`` is T_map_base as it takes itself to be, ``time_s`` the time on the clock of its scans. ``scan`` is its
    newest scan, None while that is not in the map, and ``scan_pose`` T_map_laser there. ``number`` grows with each
    newest scan; it is less than before where the map was brought back to an earlier one. ``topic`` is that of the scan,
    of all ``topics`` of scans that are mapped; empty where there are none.
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
    """Scans in a map: the first ``stop`` of a log, with one of its trajectories."""

    log: ScanLog
    trajectory: str
    stop: int
    stamps_s: Float64Array  #: (n_scans,), as in the ``frame`` message


@dataclass(frozen=True, slots=True)
class ExplainedMap:
    """A map whose cells can be asked about: its layer, and the logs of the ``index`` scans in it."""

    layer: GridLayer
    grid: OccupancyGrid
    config: MappingConfig
    scans: Callable[[], Sequence[MappedScans]]
    index: int


@dataclass(frozen=True, slots=True, eq=False)
class StaticMap:
    """A map that does not change by itself.

    ``keepout`` and ``speed`` (rows, cols) int8 are its masks of keepout zones and of speed limits, 0 … 100.
    """

    grid: OccupancyGrid
    keepout: Int8Array | None = None
    speed: Int8Array | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """A static map beside the source's own.

    ``title`` completes "Which map: …". ``read`` returns it, and raises :class:`mapper.core.errors.ConfigError` where
    there is none; ``version`` returns another object when there is another map. ``is_first`` says whether the poses
    are in this map now, so that it is the one to begin with.
    """

    title: str
    read: Callable[[], StaticMap]
    version: Callable[[], object] = lambda: None
    is_first: Callable[[], bool] = lambda: False


@dataclass(frozen=True, slots=True)
class OtherMap:
    """A map beside the source's own that changes.

    ``read`` returns another object when it has changed, None while there is none; ``title`` is as that of a plan.
    """

    title: str
    read: Callable[[], OccupancyGrid | None]


@dataclass(slots=True)
class Offers:
    """What a source offers its parts, and what earlier parts offer later ones; what there is not is None or left out.

    ``grid`` returns the source's map, which ``map_title`` describes as the title of a plan does, and ``robot`` the
    robot in it; ``drive`` drives the robot with velocities in m/s and rad/s. ``plans`` and ``maps`` are other maps by
    name. ``costs`` are costs of a layer of a costmap by the layer's name: another object when they have changed, None
    while there are none. ``costing`` has the costs that a path is planned on.

    ``map`` is a map of the library, which is shown by itself.
    ``explained`` returns the maps whose cells can be asked about, the one that is meant by default first.
    ``recording`` is the log that is played, ``update_log`` replaces it by one with other trajectories. ``simulation``
    is the simulated world with its robot.
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
    """A capability of a session. Each method has a default, and runs on a worker thread unless stated otherwise."""

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

    @property
    def answering(self) -> str:
        """Subject of an answer that is being computed beside the ticks, "" for none (any thread)."""
        return ""

    @property
    def hint(self) -> str:
        """The effect of a click into the 3D view where the click is for this part, "" where it is not (event loop)."""
        return ""

    @property
    def logs(self) -> Sequence[ScanLog]:
        """Logs that it holds beside the source's (any thread)."""
        return ()

    @property
    def has_deferred_work(self) -> bool:
        """Whether there is work that its layers do not depend on (event loop)."""
        return False

    def run_deferred_work(self, result: TickResult) -> None:
        """Do the deferred work, if there is some."""

    def messages(self) -> Sequence[Struct]:
        """Return the messages for a new client: the newest of each type."""
        return ()

    def history(self) -> Sequence[Struct]:
        """Return the commands from which another session gets the same; none while it is off."""
        return ()

    def handle(self, command: Any, result: TickResult) -> None:  # noqa: ANN401 - one of the part's own commands
        """Carry out one of :attr:`commands`. Raises as :meth:`server.sessions.model.SessionModel.handle`."""

    def note(self, command: Struct, result: TickResult) -> None:
        """Take note of a command that the source has carried out, such as another world."""

    def advance(self, seconds: float, result: TickResult) -> float:  # noqa: ARG002 - most parts do not drive
        """Act before the time of a simulation passes; return after how many of the ``seconds`` to be called again."""
        return seconds

    def changed(self, result: TickResult) -> None:
        """Follow the source's changes in this tick (``result`` has the changed map cells), and update the layers."""

    def forget(self) -> None:
        """Read again what belongs to trajectories of the log: one of them was replaced."""

    def over(self, flat: list[Drawing]) -> list[Drawing]:
        """Return the source's drawings, without those that this part replaces (event loop, between two ticks)."""
        return flat

    def drawings(self) -> list[Drawing]:
        """Return what it shows in 3D (event loop, between two ticks)."""
        return []
