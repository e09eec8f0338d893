"""The patches of an uploaded cloud as costs of a layer of a log's costmap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry
from server.library.packs.given_map import public_map
from server.sessions.models.cloud_terrain import CloudPoints
from server.sessions.models.lab_terrain import assessed
from server.sessions.models.volume_start import bounds_of

if TYPE_CHECKING:
    from mapper.terrain import Terrain
    from mapper.volume.scans.scan_sequence import ScanSequence


@dataclass(frozen=True, slots=True, eq=False)
class TerrainOfCloud:
    """The costs of the patches of a cloud. ``geometry`` has them in the file's own coordinates."""

    log_id: str
    title: str
    geometry: GridGeometry
    terrain: Terrain

    @classmethod
    def of(
        cls, log_id: str, title: str, scans: ScanSequence, progress: Callable[[float], None] | None = None
    ) -> TerrainOfCloud:
        """Assess the points of ``scans`` by the parameters that a cloud of their density has at first.

        ``progress`` is called with the share that is done, and may raise. Raises
        :class:`mapper.core.errors.MapperError` for a cloud of which no patches can be made.
        """
        points = CloudPoints(scans, *bounds_of(scans))
        places, bounds, _ = points.read()
        found = assessed(places, bounds, points.first, progress=progress)
        if found is None:
            raise ConfigError("terrain.few_points", "The cloud has fewer than three points: they make no terrain.")
        geometry = found.terrain.geometry
        x, y, yaw = geometry.origin
        there = replace(geometry, origin=(x + float(scans.offset[0]), y + float(scans.offset[1]), yaw))
        return cls(log_id, title, there, found.terrain)

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols), as :meth:`mapper.terrain.Terrain.costs` does."""
        return self.terrain.costs()

    def why(self, row: int, col: int) -> str:
        """Say the class of a patch, and the slope, the roughness and the step that it comes from."""
        return self.terrain.why(row, col)

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return {**public_map(self.title, self.geometry), "classes": self.terrain.counts()}
