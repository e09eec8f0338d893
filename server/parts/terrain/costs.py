"""Terrains of the library as costs of a costmap layer: a map of classes, or the patches of a cloud."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.masks import mask_costs
from mapper.grid import GridGeometry
from server.library.packs.reference_map import MapAnswer, TerrainCounts
from server.parts.terrain.assessment import TerrainParameters, assessed

if TYPE_CHECKING:
    from mapper.terrain import Terrain
    from server.library.packs.reference_map import ReferenceMap
    from server.sessions.part import Cloud


@dataclass(frozen=True, slots=True, eq=False)
class TerrainMap:
    """The costs of a map file as written by ``gridbloom terrain``: safe patches are free, unsafe ones occupied.

    A value v between 0 and 100 costs v · 254 / 100, rounded, as in a mask of Nav2's keepout filter.
    """

    log_id: str
    given: ReferenceMap

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the map."""
        return self.given.geometry

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols)."""
        return mask_costs(self.given.values)

    def why(self, row: int, col: int) -> str:
        """Return the class of a cell in words."""
        value = int(self.given.values[row, col])
        known = {-1: "unknown", 0: "safe", 100: "unsafe"}
        return f"Terrain: {known.get(value, f'{value} of 100')}, in the map {self.given.title!r:.80}."

    def public(self) -> MapAnswer:
        """Return the answer of the HTTP interface."""
        return self.given.public()


@dataclass(frozen=True, slots=True, eq=False)
class TerrainOfCloud:
    """The costs of the patches of a cloud. ``geometry`` is in the file's own coordinates."""

    log_id: str
    title: str
    geometry: GridGeometry
    terrain: Terrain

    @classmethod
    def of(
        cls,
        log_id: str,
        title: str,
        cloud: Cloud,
        offset: Float64Array,
        progress: Callable[[float], None] | None = None,
    ) -> TerrainOfCloud:
        """Assess the points of ``cloud`` with the initial parameters for a cloud of its density.

        ``offset`` (3,) is what to add to the points to get the file's coordinates, metres. ``progress`` is called with
        the completed share, and may raise. Raises :class:`mapper.core.errors.MapperError` for a cloud that is
        unsuitable for patches.
        """
        places, bounds, _ = cloud.read()
        terrain = assessed(places, bounds, TerrainParameters.for_cloud(places), progress=progress)
        if terrain is None:
            raise ConfigError("terrain.few_points", "The cloud has fewer than three points: they make no terrain.")
        geometry = terrain.terrain.geometry
        x, y, yaw = geometry.origin
        there = replace(geometry, origin=(x + float(offset[0]), y + float(offset[1]), yaw))
        return cls(log_id, title, there, terrain.terrain)

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols), as :meth:`mapper.terrain.Terrain.costs` does."""
        return self.terrain.costs()

    def why(self, row: int, col: int) -> str:
        """Return the class of a patch in words, with the slope, the roughness and the step that determine it."""
        return self.terrain.why(row, col)

    def public(self) -> MapAnswer:
        """Return the answer of the HTTP interface."""
        return MapAnswer.of(self.title, self.geometry, classes=TerrainCounts(**self.terrain.counts()))
