"""A terrain of the library as costs of a layer of a costmap, and the map of a terrain's classes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.costmap import NO_INFORMATION
from mapper.costmap.masks import mask_costs
from mapper.grid import GridGeometry
from server.sessions.parts import TerrainCosts

if TYPE_CHECKING:
    from server.library.packs.given_map import GivenMap


@dataclass(frozen=True, slots=True, eq=False)
class TerrainMap:
    """The costs of a map file, as ``gridbloom terrain`` writes it: safe patches are free, unsafe ones occupied.

    A value v between 0 and 100 costs v · 254 / 100, rounded, as in a mask of Nav2's keepout filter.
    """

    log_id: str
    given: GivenMap

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the map."""
        return self.given.geometry

    def costs(self) -> UInt8Array:
        """Return the costs (rows, cols)."""
        return mask_costs(self.given.values)

    def why(self, row: int, col: int) -> str:
        """Say the class of a cell."""
        value = int(self.given.values[row, col])
        known = {-1: "unknown", 0: "safe", 100: "unsafe"}
        return f"Terrain: {known.get(value, f'{value} of 100')}, in the map {self.given.title!r:.80}."

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return self.given.public()


def meets(terrain: TerrainCosts, geometry: GridGeometry) -> bool:
    """Whether a known cell of a terrain is at the place of a cell of another geometry."""
    rows, cols = (terrain.costs() != NO_INFORMATION).nonzero()
    if not len(rows):
        return False
    step = max(1, len(rows) // 100_000)
    centres = terrain.geometry.cell_to_world(np.column_stack([rows[::step], cols[::step]]))
    return bool(geometry.contains(geometry.world_to_cell(centres)).any())
