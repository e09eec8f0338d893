"""Obstacles in columns of voxels (VoxelLayer): a column is lethal by how many of its voxels are marked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import UInt8Array
from mapper.costmap.costs import FREE, LETHAL, NO_INFORMATION, cells_of
from mapper.costmap.kernels.observation import lay_over
from mapper.costmap.kernels.voxels import Heights, clear_columns, mark_columns
from mapper.costmap.layers import Observation, Robot, box_of, clear_footprint, marking_of, no_bounds, part_of
from mapper.costmap.parameters import COMBINATIONS, CostmapConfig, VoxelConfig
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry

VOXEL_BITS = 16  #: voxels of a column that the bits hold
_UNKNOWN_COLUMN = 0xFFFF


class VoxelLayer:
    """Obstacles that points mark and beams clear in three dimensions, seen from above.

    ``columns`` (rows, cols) uint32 are the voxels, see :mod:`mapper.costmap.kernels.voxels`.
    """

    name = "voxel_layer"

    def __init__(self, geometry: GridGeometry, config: VoxelConfig, general: CostmapConfig) -> None:
        self._geometry, self._config = geometry, config
        first = NO_INFORMATION if general.track_unknown_space else FREE
        self.costs: UInt8Array = np.full(geometry.shape, first, dtype=np.uint8)
        self.columns: NDArray[np.uint32] = np.full(geometry.shape, _UNKNOWN_COLUMN, dtype=np.uint32)
        self._bounds = no_bounds()
        n = int(config.z_voxels)
        # The bits above the column stay unknown, and are not counted as such.
        unknown = int(config.unknown_threshold) + VOXEL_BITS - n
        self._heights = Heights(config.origin_z, config.z_resolution, n, int(config.mark_threshold), unknown)

    def observe(self, observation: Observation) -> None:
        """Clear the voxels that the beams of an observation passed, then mark those of its points."""
        config, frame, heights = self._config, self._geometry.frame, self._heights
        points, sensor = observation.points, observation.sensor
        if config.clearing:
            least, most = (
                cells_of(r, self._geometry.resolution) for r in (config.raytrace_min_range, config.raytrace_max_range)
            )
            clear_columns(points, sensor, frame, least, most, heights, self.columns, self.costs, self._bounds)
        if config.marking:
            mark_columns(points, sensor, frame, marking_of(config), heights, self.columns, self.costs, self._bounds)

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Clear the costs under the robot, not its voxels, as Nav2 does; return what changed."""
        del now
        if robot is not None and self._config.footprint_clearing_enabled:
            clear_footprint(self._geometry, robot, FREE, self.costs, self._bounds)
        box, self._bounds = box_of(self._bounds), no_bounds()
        return box

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Lay the obstacles over the master as ``combination_method`` says."""
        if self._config.enabled:
            lay_over(
                self.costs[part_of(box)], COMBINATIONS.index(self._config.combination_method), master[part_of(box)]
            )

    def marked(self, row: int, col: int) -> list[float]:
        """Return the heights in metres of the lower faces of the marked voxels of a column, lowest first."""
        bits, heights = int(self.columns[row, col]) >> VOXEL_BITS, self._heights
        return [heights.origin_z + k * heights.z_resolution for k in range(heights.z_voxels) if bits >> k & 1]

    def why(self, row: int, col: int) -> str:
        """Say how many voxels of the column are marked and unknown."""
        column, n = int(self.columns[row, col]), self._heights.z_voxels
        marked = self.marked(row, col)
        unknown = sum(not column >> (VOXEL_BITS + k) & 1 and column >> k & 1 for k in range(n))
        if self.costs[row, col] == LETHAL:
            at = ", ".join(f"{height:.2f}" for height in marked)
            return f"{len(marked)} of {n} voxels are marked, from {at} m up: lethal."
        return f"{len(marked)} of {n} voxels are marked and {unknown} unknown."
