"""Obstacles in columns of voxels (VoxelLayer): the number of marked voxels determines whether a column is lethal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.costmap.costs import LETHAL
from mapper.costmap.kernels.voxels import Heights, clear_columns, mark_columns
from mapper.costmap.layers import MarkedLayer, Observation, clearing_cells, marking_of, seen_by_sources
from mapper.costmap.parameters import CostmapConfig, VoxelConfig
from mapper.grid.occupancy_grid import GridGeometry

VOXEL_BITS = 16  #: voxels per column in the bit representation
_UNKNOWN_COLUMN = 0xFFFF


def heights_of(config: VoxelConfig) -> Heights:
    """Return the voxels of a column in the form that the kernels use."""
    n = int(config.z_voxels)
    # The bits above the column stay unknown, and are not counted as such.
    unknown = int(config.unknown_threshold) + VOXEL_BITS - n
    return Heights(config.origin_z, config.z_resolution, n, int(config.mark_threshold), unknown)


class VoxelLayer(MarkedLayer):
    """Obstacles marked by points and cleared by beams in three dimensions, seen from above.

    ``columns`` (rows, cols) uint32 are the voxels, see :mod:`mapper.costmap.kernels.voxels`.
    """

    name = "voxel_layer"

    def __init__(self, geometry: GridGeometry, config: VoxelConfig, general: CostmapConfig) -> None:
        super().__init__(geometry, config, general)
        self.columns: NDArray[np.uint32] = np.full(geometry.shape, _UNKNOWN_COLUMN, dtype=np.uint32)
        self.heights = heights_of(config)

    def observe(self, *observations: Observation) -> None:
        """Clear the voxels along the beams of all observations, then mark those of their points."""
        seen, frame, heights = seen_by_sources(self._config, observations), self._geometry.frame, self.heights
        for source, observation in seen:
            if source.clearing:
                least, most = clearing_cells(source, self._geometry)
                clear_columns(
                    observation.points,
                    observation.sensor,
                    frame,
                    least,
                    most,
                    heights,
                    self.columns,
                    self.costs,
                    self._bounds,
                )
        for source, observation in seen:
            if source.marking:
                marking = marking_of(self._config, source)
                mark_columns(
                    observation.points,
                    observation.sensor,
                    frame,
                    marking,
                    heights,
                    self.columns,
                    self.costs,
                    self._bounds,
                )

    def marked(self, row: int, col: int) -> list[float]:
        """Return the heights, metres, of the lower faces of a column's marked voxels, lowest first."""
        bits, heights = int(self.columns[row, col]) >> VOXEL_BITS, self.heights
        return [heights.origin_z + k * heights.z_resolution for k in range(heights.z_voxels) if bits >> k & 1]

    def why(self, row: int, col: int) -> str:
        """Describe how many voxels of the column are marked and unknown."""
        column, n = int(self.columns[row, col]), self.heights.z_voxels
        marked = self.marked(row, col)
        unknown = sum(not column >> (VOXEL_BITS + k) & 1 and column >> k & 1 for k in range(n))
        if self.costs[row, col] == LETHAL:
            at = ", ".join(f"{height:.2f}" for height in marked)
            return f"{len(marked)} of {n} voxels are marked, from {at} m up: lethal."
        return f"{len(marked)} of {n} voxels are marked and {unknown} unknown."
