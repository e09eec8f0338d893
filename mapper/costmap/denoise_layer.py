"""Removal of small groups of obstacles in the layers before, as sensor noise."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, UInt8Array
from mapper.costmap.costs import FREE, INSCRIBED, LETHAL, NO_INFORMATION
from mapper.costmap.layers import Robot, part_of
from mapper.costmap.parameters import CostmapConfig, DenoiseConfig
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry

FOUR = 4  #: the connectivity of cells that share an edge; any other number is 8


class DenoiseLayer:
    """Connected groups of obstacles with fewer than ``minimal_group_size`` cells become free (DenoiseLayer).

    Lethal and inscribed cells are obstacles, as are cells without information if unknown space is not tracked. Source:
    nav2_costmap_2d, denoise_layer.cpp. There groups are cut at the border of the updated area; here they are not.
    """

    def __init__(
        self, geometry: GridGeometry, config: DenoiseConfig, general: CostmapConfig, name: str = "denoise_layer"
    ) -> None:
        self.name, self._config = name, config
        self._unknown_is_obstacle = not general.track_unknown_space
        self._before: UInt8Array = np.full(
            geometry.shape, FREE if self._unknown_is_obstacle else NO_INFORMATION, dtype=np.uint8
        )
        self.costs: UInt8Array = np.full(geometry.shape, NO_INFORMATION, dtype=np.uint8)  #: FREE where it removes

    @property
    def reach(self) -> int:
        """Number of cells around a change of the layers before in which the result may change."""
        return max(0, int(self._config.minimal_group_size) - 1) if self._config.enabled else 0

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Return None, because it changes only where the layers before do."""
        del now, robot
        return None

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Free the cells of small groups. Cells outside the box still have their values from the last update."""
        if not self.reach:
            return
        rows, cols = master.shape
        self._before[part_of(box)] = master[part_of(box)]
        around = box.padded(self.reach, rows, cols)
        removed = small_groups(
            self._obstacles(self._before[part_of(around)]), int(self._config.minimal_group_size), self._connectivity
        )
        inner = removed[
            box.row0 - around.row0 : box.row1 - around.row0, box.col0 - around.col0 : box.col1 - around.col0
        ]
        self.costs[part_of(box)] = np.where(inner, FREE, NO_INFORMATION)
        master[part_of(box)][inner] = FREE

    def why(self, row: int, col: int) -> str:
        """Describe whether a group was removed here."""
        least = int(self._config.minimal_group_size)
        if self.costs[row, col] == FREE:
            return f"The obstacle here is of a group of fewer than {least} cells, which is removed as noise."
        return f"No obstacle of a group of fewer than {least} cells is here."

    @property
    def _connectivity(self) -> int:
        return FOUR if int(self._config.group_connectivity_type) == FOUR else 8

    def _obstacles(self, costs: UInt8Array) -> BoolArray:
        kinds = (LETHAL, INSCRIBED, NO_INFORMATION) if self._unknown_is_obstacle else (LETHAL, INSCRIBED)
        return np.isin(costs, kinds)


def small_groups(obstacles: BoolArray, least: int, connectivity: int) -> BoolArray:
    """Return which ``obstacles`` (rows, cols) bool are in connected groups of fewer than ``least`` cells.

    ``connectivity`` is 4 or 8.
    """
    from scipy import ndimage  # noqa: PLC0415 - few costmaps have the layer

    labels, n = ndimage.label(obstacles, structure=np.ones((3, 3)) if connectivity == 8 else None)
    sizes = np.bincount(labels.reshape(-1), minlength=n + 1)
    small = sizes < least
    small[0] = False
    return np.asarray(small[labels])
