"""Optional parts of a model: a recording, a comparison, costs. Routes check for these, not for kinds of sessions."""

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
        """The name of the current trajectory."""

    @abstractmethod
    def same_paths(self) -> Mapping[str, str]:
        """Return, for each trajectory with the same path as an earlier one, the name of the earlier one."""

    @abstractmethod
    def compared(self) -> tuple[str, str] | None:
        """Return the reference and the estimate whose errors are shown first; None for a log with one trajectory."""

    @abstractmethod
    def first_config(self) -> MappingConfig:
        """Return the initial parameters for the log."""

    @abstractmethod
    def view(self) -> LogView:
        """Return the current view: sensor, trajectory, parameters, scans in the map."""

    @abstractmethod
    async def growing_map(self) -> tuple[GrowingMap, str]:
        """Return the current map as a sequence of scans, and the name of its trajectory, between two ticks."""

    @abstractmethod
    def map_series(self) -> Series | float:
        """Return the effect of the scans on the map with the current parameters and trajectory.

        While it is being computed, return the completed share, 0 to 1. The computation ends if it is no longer
        requested. Raises like :func:`mapper.replay.map_series.map_series`.
        """

    @property
    @abstractmethod
    def examined_share(self) -> float | None:
        """Completed share of the examination with the current trajectory, 0 to 1; None before it has started."""

    @property
    @abstractmethod
    def diagnosis(self) -> Diagnosis | None:
        """Diagnosis with the current trajectory; None unless an examination has finished without an error."""

    @abstractmethod
    async def examined(self) -> Diagnosis:
        """Return the diagnosis of the log with the current trajectory.

        Raises like :func:`mapper.diagnosis.examine`.
        """


class Viewed(ABC):
    """View of an upload in a session, for a link that opens the same view."""

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
        """Return the maps A and B, to be read while the session is locked. Raises like :meth:`compared`."""

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
        """The loops shown in the 3D view, None if none are shown."""

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
        """Return the residuals of the graph's measurements over time."""

    @abstractmethod
    async def near(self, x: float, y: float, source: GraphSource) -> TriedNear:
        """Return the loops that were tried near a place, given in map metres."""

    @abstractmethod
    async def candidate(self, candidate: int, source: GraphSource) -> TriedLoopScans:
        """Return a tried loop with both of its scans."""

    @abstractmethod
    async def change(self, change: GraphChange, source: GraphSource) -> PoseGraphAnswer:
        """Change the graph and map along its poses; return the same as :meth:`public`."""

    @abstractmethod
    async def files(self, source: GraphSource) -> tuple[str, bytes, bytes]:
        """Return the name of the trajectory, its current poses as TUM lines, and the file of the current graph."""


@dataclass(frozen=True, slots=True)
class FilterHistory:
    """Uncertainty of a localization in ``map`` along the log, at some of its ``scans``.

    ``deviation_m`` is that of the position, ``entropy`` is in bits, ``fit`` 0 to 1. ``first_converged`` is the first of
    all scans at which the filter had converged.
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
        """Return the uncertainty of the poses along the log, None if they do not come from localization."""


class Volumetric(ABC):
    """The 3D map of a session."""

    is_on: bool  #: whether there is one

    @property
    @abstractmethod
    def is_asked(self) -> bool:
        """Whether a click in the 3D view explains a voxel."""

    @abstractmethod
    def question(self, origin: Point, direction: Point) -> Struct:
        """Return the command that explains the voxel that a line of sight meets."""

    @abstractmethod
    def met(self, origin: Point, direction: Point) -> tuple[Point, float] | None:
        """Return where a line of sight meets what is drawn of the map, metres, and the side length of the voxel there.

        The side is 0 for a measured point. Returns None if the line meets nothing.
        """

    @abstractmethod
    def clipped(self, handle: str, position: Point) -> Struct | None:
        """Return the command that moves a face of the clip box by its handle to ``position``; None for another name."""

    @abstractmethod
    def octree_bytes(self, kind: str) -> bytes:
        """Return the current map as a ``.bt`` or ``.ot`` file, to be read while the session is locked."""

    @abstractmethod
    def mesh_bytes(self, kind: str) -> bytes:
        """Return the current surface, or the outside of the voxels, as a ``.ply`` or ``.glb`` file.

        Raises :class:`ConfigError` if there is none.
        """

    @abstractmethod
    def selection_bytes(self) -> bytes:
        """Return the points in the clip box as a ``.ply`` file; for an octree, the centres of its occupied voxels.

        Raises :class:`ConfigError` if there is none.
        """

    @property
    @abstractmethod
    def above(self) -> OccupancyGrid | None:
        """The map from above, of a band of heights; None if nothing is known there."""


class DepthSensing(ABC):
    """A robot that can have a depth camera."""

    @abstractmethod
    def newest_depths(self) -> tuple[Float32Array, float] | None:
        """Return its newest image (rows, cols), metres ahead, 0 for no return, and its range, metres (any thread).

        Returns None without a depth camera and before its first image.
        """


class EditedFiles(ABC):
    """A map being edited."""

    @property
    @abstractmethod
    def geometry(self) -> GridGeometry:
        """The geometry of the current map."""

    @abstractmethod
    async def files(self, stem: str) -> list[tuple[str, bytes]]:
        """Return the files of the current map by name: the image, its yaml, those of the keepout mask, the edits."""


@dataclass(frozen=True, slots=True)
class FootprintAnswer:
    """The footprint of a robot: its corners in its frame, and both radii of the padded footprint, metres."""

    footprint: list[tuple[float, float]]
    inscribed_radius: float
    circumscribed_radius: float


class Costed(ABC):
    """The costs of a session: a costmap over its map, or a recorded one. Read only while the session is locked."""

    @abstractmethod
    def present_costs(self) -> RecordedCostmap | None:
        """Return a copy of the current costs; None if there are none."""

    @abstractmethod
    def present_footprint(self) -> FootprintAnswer | None:
        """Return the robot's footprint, None if there is none."""

    @abstractmethod
    def present_masks(self) -> dict[str, Int8Array]:
        """Return the painted masks (rows, cols) on the cells of the costs.

        They are ``keepout`` (−1: unpainted) and ``speed`` (0: unpainted). Empty if nothing is painted.
        """


class LayerCosts(Protocol):
    """Costs of another part or an upload for a costmap layer, on their own cells."""

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the map."""

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols): 254 where a robot must not be, 255 where unknown."""

    def why(self, row: int, col: int) -> str:
        """Return one sentence that explains the cost of a cell."""


class Costs(Protocol):
    """The costs of a costmap, for planning and following a path."""

    revision: int  #: changes with the costs and the parameters

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the costs."""

    @property
    def costs(self) -> UInt8Array:
        """The costs (rows, cols), an array that the costmap keeps updating."""

    @property
    def planner(self) -> PlannerConfig:
        """Parameters of the planner."""

    @property
    def pursuit(self) -> PursuitConfig:
        """Parameters of the follower of the path."""

    @property
    def radius(self) -> float:
        """Circumscribed radius of the robot including its padding, metres."""

    @property
    def speed_filters(self) -> tuple[SpeedFilter, ...]:
        """The speed limits."""

    def speed_limit(self, pose: Pose) -> SpeedLimit | None:
        """Return the speed limit for a robot at ``pose``; None if speed limits are off."""


class Costing(Protocol):
    """A part with costs."""

    is_on: bool  #: whether there are any

    @property
    def costmap(self) -> Costs | None:
        """The costs, None while there are none."""


class UploadedCosts(LayerCosts, Protocol):
    """Costs of an upload for a costmap layer."""

    @property
    def log_id(self) -> str:
        """Id of the upload."""

    def public(self) -> MapAnswer:
        """Return the answer of the HTTP interface."""
