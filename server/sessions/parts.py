"""Optional parts of a model: a recording, a comparison, a story. Routes check for these, not for a kind."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.compare import Comparison
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from server.library.packs.given_map import MapAnswer
from server.sessions.graph_answers import EdgeAnswer, PoseGraphAnswer, ScoreLandscape, TriedLoopScans, TriedNear
from server.sessions.view import GraphChange, LogView, Wanted

if TYPE_CHECKING:
    from mapper.core.array_types import Int8Array, UInt8Array
    from mapper.diagnosis import Diagnosis
    from mapper.io.costmaps import RecordedCostmap
    from mapper.io.export import GrowingMap


GraphSource: TypeAlias = Callable[[str], Awaitable[bytes | None]]  #: reads the file of a trajectory's pose graph


class Recording(Protocol):
    """The log of a session."""

    log_id: str

    @property
    def log(self) -> ScanLog:
        """The log."""

    @property
    def trajectory(self) -> str:
        """The name of the trajectory in use."""

    def first_config(self) -> MappingConfig:
        """Return the initial parameters for the log."""

    def view(self) -> LogView:
        """Return the present view: sensor, trajectory, parameters, scans in the map."""

    async def growing_map(self) -> tuple[GrowingMap, str]:
        """Return the present map as a sequence of its scans, and the name of its trajectory, between two ticks."""

    @property
    def examined_share(self) -> float | None:
        """The share of the examination with the present trajectory that is done, 0 to 1; None before it has begun."""

    async def examined(self) -> Diagnosis:
        """Return the diagnosis of the log with the present trajectory.

        Raises as :func:`mapper.diagnosis.examine`.
        """


class Viewed(Protocol):
    """View of an upload in a session, for a link that opens the same."""

    log_id: str

    def view(self) -> LogView:
        """Return the present view. ``trajectory`` is the topic for recorded costmaps, ``index`` the number of one."""


class Comparable(Protocol):
    """The comparison of a session's map, B, with another one, A."""

    async def compare(self, wanted: Wanted | None) -> None:
        """Compare with another map; None ends the comparison. Raises :class:`mapper.core.errors.MapperError`."""

    async def compared(self) -> tuple[dict[str, Any], Comparison]:
        """Return the description of A and the comparison. Raises :class:`mapper.core.errors.MapperError`."""

    def grids(self) -> tuple[OccupancyGrid, OccupancyGrid]:
        """Return the maps A and B, to be read while the session is locked. Raises as :meth:`compared`."""

    def description(self) -> dict[str, Any] | None:
        """Return the description of A, None if there is no comparison."""


class Graphed(Protocol):
    """The pose graph of a session's trajectory. All of it raises :class:`mapper.core.errors.MapperError`."""

    async def public(self, source: GraphSource) -> PoseGraphAnswer:
        """Return the loops of the graph, and show its layer."""

    async def edge(self, edge: int, source: GraphSource) -> EdgeAnswer:
        """Return an edge with both of its scans."""

    async def landscape(self, edge: int, source: GraphSource) -> ScoreLandscape:
        """Return the score of the poses around an edge."""

    async def near(self, x: float, y: float, source: GraphSource) -> TriedNear:
        """Return the loops that were tried near a place, map metres."""

    async def candidate(self, candidate: int, source: GraphSource) -> TriedLoopScans:
        """Return a loop that was tried with both of its scans."""

    async def change(self, change: GraphChange, source: GraphSource) -> PoseGraphAnswer:
        """Change the graph and map along its poses; return as :meth:`public`."""

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


class Localized(Protocol):
    """The localization of a session's trajectory in a map."""

    async def public(self, source: GraphSource) -> FilterHistory | None:
        """Return how certain the poses are along the log, None where they come from no localization."""


class Volumetric(Protocol):
    """The map in 3D of a session."""

    @property
    def is_on(self) -> bool:
        """Whether there is one now."""

    @property
    def is_asked(self) -> bool:
        """Whether a click in the 3D view asks about a voxel."""

    def octree_bytes(self, kind: str) -> bytes:
        """Return the present map as a file ``.bt`` or ``.ot``, to be read while the session is locked."""

    def mesh_bytes(self, kind: str) -> bytes:
        """Return the present surface, or the outside of the voxels, as a file ``.ply`` or ``.glb``.

        Raises :class:`ConfigError` where there is none.
        """

    @property
    def above(self) -> OccupancyGrid | None:
        """The map from above, of a band of heights; None where nothing is known there."""


class EditedFiles(Protocol):
    """A map that is edited."""

    async def files(self, stem: str) -> list[tuple[str, bytes]]:
        """Return the files of the present map, by name: the image, its yaml, the keepout mask's, the edits."""


@dataclass(frozen=True, slots=True)
class FootprintAnswer:
    """The footprint of a robot: its corners in its frame, metres, and both radii of the padded one, metres."""

    footprint: list[tuple[float, float]]
    inscribed_radius: float
    circumscribed_radius: float


class Costed(Protocol):
    """The costs of a session: a costmap over its map, or a recorded one. To be read while the session is locked."""

    def history(self) -> list[dict[str, Any]]:
        """Return the commands from which another session gets the same costmap and goal; none without a costmap."""

    def present_costs(self) -> RecordedCostmap | None:
        """Return the present costs, in an array of their own; None where there are none."""

    def present_footprint(self) -> FootprintAnswer | None:
        """Return the robot's footprint, None where there is none."""

    def present_masks(self) -> dict[str, Int8Array]:
        """Return the painted masks (rows, cols) on the costs' cells.

        ``keepout``, −1 for none, and ``speed``, 0 for none; none of them where nothing is painted.
        """


class Story(Protocol):
    """The recorded history of a session, from which it can be reproduced."""

    async def current(self) -> dict[str, Any]:
        """Return the story, between two ticks, of all that was asked of the session before."""


class LayerCosts(Protocol):
    """Costs that another part, or an upload, has for a layer of a costmap, on cells of its own."""

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the map."""

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols): 254 where a robot must not be, 255 where that is unknown."""

    def why(self, row: int, col: int) -> str:
        """Say in one sentence why a cell has its cost."""


class UploadedCosts(LayerCosts, Protocol):
    """Such costs of an upload."""

    @property
    def log_id(self) -> str:
        """The upload."""

    def public(self) -> MapAnswer:
        """Return what the HTTP interface shows."""
