"""Optional parts of a model: a recording, a comparison, costs. Routes check for these, not for a kind."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.compare import Comparison
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from server.library.packs.reference_map import MapAnswer
from server.sessions.graph_answers import (
    EdgeAnswer,
    PoseGraphAnswer,
    ScanConstraints,
    ScoreLandscape,
    TriedLoopScans,
    TriedNear,
)
from server.sessions.view import GraphChange, LogView, MapRequest, Pose
from server.stream.message_parts import Compared

if TYPE_CHECKING:
    import numpy as np
    from msgspec import Struct
    from numpy.typing import NDArray

    from mapper.core.array_types import Float32Array, Float64Array, Int8Array, UInt8Array
    from mapper.costmap import SpeedFilter, SpeedLimit
    from mapper.diagnosis import Diagnosis
    from mapper.io.contents.model import Series
    from mapper.io.costmaps import RecordedCostmap
    from mapper.io.export import GrowingMap
    from mapper.planning.parameters import PlannerConfig, PursuitConfig
    from mapper.replay import Replay
    from server.sessions.drawings import Point


GraphSource: TypeAlias = Callable[[str], Awaitable[bytes | None]]  #: reads the file of a trajectory's pose graph


class Recording(ABC):
    """The log of a session."""

    log_id: str
    replay: Replay  #: which makes its map
    recorded: Float64Array  #: (n_scans,) seconds since the first scan

    @property
    @abstractmethod
    def log(self) -> ScanLog:
        """The log."""

    @property
    @abstractmethod
    def trajectory(self) -> str:
        """The name of the trajectory in use."""

    @abstractmethod
    def same_paths(self) -> Mapping[str, str]:
        """Return for each trajectory whose path another one before it has the name of that one."""

    @abstractmethod
    def compared(self) -> tuple[str, str] | None:
        """Return the reference and the estimate whose errors are told first; None for a log with one trajectory."""

    @abstractmethod
    def first_config(self) -> MappingConfig:
        """Return the initial parameters for the log."""

    @abstractmethod
    def view(self) -> LogView:
        """Return the present view: sensor, trajectory, parameters, scans in the map."""

    @abstractmethod
    async def growing_map(self) -> tuple[GrowingMap, str]:
        """Return the present map as a sequence of its scans, and the name of its trajectory, between two ticks."""

    @abstractmethod
    def map_series(self) -> Series | float:
        """Return the effect of the scans on the map with the current parameters and trajectory.

        While it is being computed, return the completed share, 0 to 1. The computation ends if it is no longer
        requested. Raises like :func:`mapper.replay.map_series.map_series`.
        """

    @property
    @abstractmethod
    def examined_share(self) -> float | None:
        """The share of the examination with the present trajectory that is done, 0 to 1; None before it has begun."""

    @property
    @abstractmethod
    def diagnosis(self) -> Diagnosis | None:
        """The diagnosis with the present trajectory; None where the log was not examined, or is being so."""

    @abstractmethod
    async def examined(self) -> Diagnosis:
        """Return the diagnosis of the log with the present trajectory.

        Raises as :func:`mapper.diagnosis.examine`.
        """


class Viewed(ABC):
    """View of an upload in a session, for a link that opens the same."""

    log_id: str

    @abstractmethod
    def view(self) -> LogView:
        """Return the current view.

        For recorded costmaps, ``trajectory`` is the topic and ``index`` the number of the costmap.
        """


class Comparable(ABC):
    """The comparison of a session's map, B, with another one, A."""

    @abstractmethod
    async def compare(self, requested: MapRequest | None) -> None:
        """Compare with another map; None ends the comparison. Raises :class:`mapper.core.errors.MapperError`."""

    @abstractmethod
    async def compared(self) -> tuple[Compared, Comparison]:
        """Return the description of A and the comparison. Raises :class:`mapper.core.errors.MapperError`."""

    @abstractmethod
    def grids(self) -> tuple[OccupancyGrid, OccupancyGrid]:
        """Return the maps A and B, to be read while the session is locked. Raises as :meth:`compared`."""

    @abstractmethod
    def description(self) -> Compared | None:
        """Return the description of A, None if there is no comparison."""


@dataclass(frozen=True, slots=True)
class ShownLoops:
    """Loops of a pose graph in 3D: the numbers of their ``edges``, and their ``ends`` (n, 2, 3), map metres."""

    edges: NDArray[np.int64]
    ends: Float64Array


class Graphed(ABC):
    """The pose graph of a session's trajectory. Its methods raise :class:`mapper.core.errors.MapperError`."""

    @property
    @abstractmethod
    def loops(self) -> ShownLoops | None:
        """The loops that the 3D view shows, None while it shows none."""

    @abstractmethod
    async def public(self, source: GraphSource) -> PoseGraphAnswer:
        """Return the loops of the graph, and show its layer."""

    @abstractmethod
    async def edge(self, edge: int, source: GraphSource) -> EdgeAnswer:
        """Return an edge with both of its scans."""

    @abstractmethod
    async def constraints(self, scan: int, source: GraphSource) -> ScanConstraints:
        """Return the edges that determine the pose of a scan."""

    @abstractmethod
    async def landscape(self, edge: int, source: GraphSource) -> ScoreLandscape:
        """Return the score of the poses around an edge."""

    @abstractmethod
    async def residuals(self, source: GraphSource) -> Series:
        """Return by how much the poses miss the graph's measurements, over time."""

    @abstractmethod
    async def near(self, x: float, y: float, source: GraphSource) -> TriedNear:
        """Return the loops that were tried near a place, map metres."""

    @abstractmethod
    async def candidate(self, candidate: int, source: GraphSource) -> TriedLoopScans:
        """Return a loop that was tried with both of its scans."""

    @abstractmethod
    async def change(self, change: GraphChange, source: GraphSource) -> PoseGraphAnswer:
        """Change the graph and map along its poses; return as :meth:`public`."""

    @abstractmethod
    async def files(self, source: GraphSource) -> tuple[str, bytes, bytes]:
        """Return the name of the trajectory, its present poses as TUM lines, and the file of the present graph."""


@dataclass(frozen=True, slots=True)
class FilterHistory:
    """How certain the poses of a localization in ``map`` are along the log, at some of its ``scans``.

    ``deviation_m`` is that of the place, ``entropy`` bits, ``fit`` 0 to 1; ``first_converged`` is the first scan of all
    at which the filter had converged.
    """

    map: MapAnswer
    scans: list[int]
    seconds: list[float]
    entropy: list[float]
    deviation_m: list[float]
    fit: list[float]
    is_converged: list[bool]
    n_particles: list[int]
    first_converged: int | None


class Localized(ABC):
    """The localization of a session's trajectory in a map."""

    @abstractmethod
    async def public(self, source: GraphSource) -> FilterHistory | None:
        """Return how certain the poses are along the log, None where they come from no localization."""


class Volumetric(ABC):
    """The map in 3D of a session."""

    is_on: bool  #: whether there is one

    @property
    @abstractmethod
    def is_asked(self) -> bool:
        """Whether a click in the 3D view asks about a voxel."""

    @abstractmethod
    def question(self, origin: Point, direction: Point) -> Struct:
        """Return the command that asks about the voxel that a line of sight meets."""

    @abstractmethod
    def met(self, origin: Point, direction: Point) -> tuple[Point, float] | None:
        """Return where a line of sight meets what is drawn of the map, metres, and the side of the voxel that is there.

        The side is 0 where it is a measured point. None: it meets nothing.
        """

    @abstractmethod
    def clipped(self, handle: str, position: Point) -> Struct | None:
        """Return the command that moves a face of the clip box by its handle to ``position``; None for another name."""

    @abstractmethod
    def octree_bytes(self, kind: str) -> bytes:
        """Return the present map as a file ``.bt`` or ``.ot``, to be read while the session is locked."""

    @abstractmethod
    def mesh_bytes(self, kind: str) -> bytes:
        """Return the present surface, or the outside of the voxels, as a file ``.ply`` or ``.glb``.

        Raises :class:`ConfigError` where there is none.
        """

    @abstractmethod
    def selection_bytes(self) -> bytes:
        """Return the points in the clip box as a file ``.ply``; of an octree the centres of its occupied voxels.

        Raises :class:`ConfigError` where there is none.
        """

    @property
    @abstractmethod
    def above(self) -> OccupancyGrid | None:
        """The map from above, of a band of heights; None where nothing is known there."""


class DepthSensing(ABC):
    """A robot that can have a depth camera."""

    @abstractmethod
    def newest_depths(self) -> tuple[Float32Array, float] | None:
        """Return its newest image (rows, cols), metres ahead, 0 for no return, and its range, metres (any thread).

        None without a depth camera, and before its first image.
        """


class EditedFiles(ABC):
    """A map that is edited."""

    @property
    @abstractmethod
    def geometry(self) -> GridGeometry:
        """The geometry of the present map."""

    @abstractmethod
    async def files(self, stem: str) -> list[tuple[str, bytes]]:
        """Return the files of the present map, by name: the image, its yaml, the keepout mask's, the edits."""


@dataclass(frozen=True, slots=True)
class FootprintAnswer:
    """The footprint of a robot: its corners in its frame, metres, and both radii of the padded one, metres."""

    footprint: list[tuple[float, float]]
    inscribed_radius: float
    circumscribed_radius: float


class Costed(ABC):
    """The costs of a session: a costmap over its map, or a recorded one. To be read while the session is locked."""

    @abstractmethod
    def present_costs(self) -> RecordedCostmap | None:
        """Return the present costs, in an array of their own; None where there are none."""

    @abstractmethod
    def present_footprint(self) -> FootprintAnswer | None:
        """Return the robot's footprint, None where there is none."""

    @abstractmethod
    def present_masks(self) -> dict[str, Int8Array]:
        """Return the painted masks (rows, cols) on the costs' cells.

        ``keepout``, −1 for none, and ``speed``, 0 for none; none of them where nothing is painted.
        """


class LayerCosts(Protocol):
    """Costs that another part, or an upload, has for a layer of a costmap, on cells of its own."""

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the map."""

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols): 254 where a robot must not be, 255 where that is unknown."""

    def why(self, row: int, col: int) -> str:
        """Say in one sentence why a cell has its cost."""


class Costs(Protocol):
    """The costs of a costmap, on which a path is planned and followed."""

    revision: int  #: changes with the costs and the parameters

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the costs."""

    @property
    def costs(self) -> UInt8Array:
        """The costs (rows, cols), an array that the costmap goes on writing."""

    @property
    def planner(self) -> PlannerConfig:
        """Parameters of the planner."""

    @property
    def pursuit(self) -> PursuitConfig:
        """Parameters of the follower of the path."""

    @property
    def radius(self) -> float:
        """Circumscribed radius of the robot with its padding, metres."""

    @property
    def speed_filters(self) -> tuple[SpeedFilter, ...]:
        """The speed limits."""

    def speed_limit(self, pose: Pose) -> SpeedLimit | None:
        """Return the speed limit of a robot at ``pose``; None where speed limits are off."""


class Costing(Protocol):
    """A part with costs."""

    is_on: bool  #: whether there are any

    @property
    def costmap(self) -> Costs | None:
        """The costs, None while there are none."""


class UploadedCosts(LayerCosts, Protocol):
    """Such costs of an upload."""

    @property
    def log_id(self) -> str:
        """The upload."""

    def public(self) -> MapAnswer:
        """Return what the HTTP interface shows."""
