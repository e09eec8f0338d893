"""Obstacle layer with a lifetime."""

from __future__ import annotations

import heapq

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array
from mapper.costmap.costs import LETHAL, NO_INFORMATION
from mapper.costmap.kernels.observation import lay_over
from mapper.costmap.layers import (
    Observation,
    Robot,
    box_of,
    clear,
    clear_footprint,
    mark,
    no_bounds,
    part_of,
    seen_by_sources,
)
from mapper.costmap.parameters import COMBINATIONS, CostmapConfig, DecayConfig
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry


class DecayLayer:
    """Obstacles with a lifetime: those not seen again within ``lifetime`` seconds are removed.

    Nav2 itself has no such layer; its documentation refers to the spatio-temporal voxel layer, whose voxels decay over
    time.
    """

    name = "dynamic_layer"

    def __init__(self, geometry: GridGeometry, config: DecayConfig, general: CostmapConfig) -> None:
        del general
        self._geometry, self._config = geometry, config
        self.costs: UInt8Array = np.full(geometry.shape, NO_INFORMATION, dtype=np.uint8)
        self._marked: Float64Array = np.full(geometry.shape, -np.inf)  #: time of marking, s
        self._now = -np.inf
        self._bounds = no_bounds()
        self._waiting: list[tuple[float, int, CellBox]] = []  #: stamp, number and box of unexpired observations
        self._n = 0

    @property
    def config(self) -> DecayConfig:
        """The current parameters."""
        return self._config

    def configure(self, config: DecayConfig) -> None:
        """Replace the parameters; existing marks are kept or removed according to the new lifetime."""
        self._config = config
        self._wait_for_all()

    def observe(self, *observations: Observation) -> None:
        """Clear the cells along the beams of all observations, then mark their endpoints with the observations'
        stamps.
        """
        seen = seen_by_sources(self._config, observations)
        for source, observation in seen:
            clear(self._geometry, source, observation, -np.inf, self._marked, self._bounds)
        for source, observation in seen:
            marked = no_bounds()
            mark(self._geometry, self._config, source, observation, observation.stamp, self._marked, marked)
            self._remember(marked, observation.stamp)

    def _remember(self, marked: Int64Array, stamp: float) -> None:
        """Schedule an update of the marked cells now and when their lifetime ends."""
        box = box_of(marked)
        if box is not None:
            self._touch(box)
            heapq.heappush(self._waiting, (stamp, self._n, box))
            self._n += 1

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Remove obstacles older than the lifetime at ``now``, in seconds; return the box that changed.

        Only the boxes of observations since the last call and of expired ones are examined, unless ``now`` is before
        the time of the last call.
        """
        if robot is not None and self._config.footprint_clearing_enabled:
            clear_footprint(self._geometry, robot, -np.inf, self._marked, self._bounds)
        oldest = now - self._config.lifetime
        if now < self._now:
            self._wait_for_all()
        while self._waiting and self._waiting[0][0] < oldest:
            self._touch(heapq.heappop(self._waiting)[2])
        self._now = now
        box, self._bounds = box_of(self._bounds), no_bounds()
        if box is None:
            return None
        costs = self.costs[part_of(box)]
        alive = self._marked[part_of(box)] >= oldest
        rows, cols = np.nonzero(alive != (costs == LETHAL))
        costs[...] = np.where(alive, np.uint8(LETHAL), np.uint8(NO_INFORMATION))
        if len(rows) == 0:
            return None
        return CellBox(
            box.row0 + int(rows.min()),
            box.row0 + int(rows.max()) + 1,
            box.col0 + int(cols.min()),
            box.col0 + int(cols.max()) + 1,
        )

    def _wait_for_all(self) -> None:
        """Examine the whole grid at the next update, and when each stamp expires."""
        everything = CellBox(0, self._geometry.rows, 0, self._geometry.cols)
        self._touch(everything)
        stamps = np.unique(self._marked[np.isfinite(self._marked)])
        self._waiting = [(float(stamp), k, everything) for k, stamp in enumerate(stamps)]
        self._n = len(stamps)

    def _touch(self, box: CellBox) -> None:
        bounds = self._bounds
        bounds[0], bounds[1] = min(int(bounds[0]), box.row0), max(int(bounds[1]), box.row1)
        bounds[2], bounds[3] = min(int(bounds[2]), box.col0), max(int(bounds[3]), box.col1)

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Apply the unexpired obstacles to the master."""
        if self._config.enabled:
            lay_over(
                self.costs[part_of(box)], COMBINATIONS.index(self._config.combination_method), master[part_of(box)]
            )

    def why(self, row: int, col: int) -> str:
        """Describe when the cell was last marked."""
        marked = float(self._marked[row, col])
        if marked == -np.inf:
            return "No obstacle was seen here, or a beam passed through since."
        age = self._now - marked
        state = "kept" if self.costs[row, col] == LETHAL else "forgotten"
        return f"Marked {age:.1f} s ago and {state}: the lifetime is {self._config.lifetime:g} s."
