"""One scan of a live robot, added to a grid in one call of a kernel where the parameters allow it.

The general update prepares arrays for any number of scans and threads, which takes longer than the drawing of one scan.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose_one
from mapper.grid import OccupancyGrid
from mapper.mapping import cell_statistics
from mapper.mapping.kernels.one_scan import BEYOND, add_scan
from mapper.mapping.scan_batch import directions
from mapper.mapping.update import WORTH_SHARING
from mapper.mapping.update_plan import UpdatePlan, check_beam_length
from mapper.sensors.scan import LaserScan, RangeScan

#: The number of cell updates, the box (row0, row1, col0, col1), and the cells that were written, row · cols + col, some
#: of them repeatedly; None where they are too many.
Touched = tuple[int, NDArray[np.int64], NDArray[np.uint32] | None]
MOST_WRITTEN = 8192  #: most cells that are listed; a scan writes about 1,000 that are not at the clamp


def is_simple(scan: RangeScan, plan: UpdatePlan) -> TypeGuard[LaserScan]:
    """Return whether :func:`update_with_scan` takes the scan: thin even beams, drawn as Bresenham's lines."""
    strategy = plan.strategy
    return (
        isinstance(scan, LaserScan)
        and len(scan.ranges) < WORTH_SHARING
        and strategy.statistics == "none"
        and not (strategy.smooth or plan.draws_cones or plan.per_scan or plan.exact_rays or plan.no_return_is_hit)
    )


def update_with_scan(
    grid: OccupancyGrid, scan: LaserScan, sensor_pose: list[float], plan: UpdatePlan
) -> Touched | None:
    """Add a scan, for which :func:`is_simple`, taken at ``sensor_pose`` (3,), ``T_map_laser``; the mount is corrected.

    The same as :func:`mapper.mapping.update.update_grid`, bit for bit; None where the grid has to grow first, and is
    unchanged. Raises as that function does.
    """
    geometry = grid.geometry
    check_beam_length(plan.beam_length, geometry.resolution)
    cell_statistics.begin(grid, plan.strategy)
    x, y, theta = compose_one(sensor_pose, plan.mount)
    sign = -1.0 if plan.upside_down else 1.0
    beams = _even_directions(sign, scan.angle_min, scan.angle_increment, len(scan.ranges))
    box = np.array([geometry.rows, 0, geometry.cols, 0], dtype=np.int64)
    written = np.empty(MOST_WRITTEN, dtype=np.uint32)
    count, n = add_scan(
        grid.log_odds, grid.observed, scan.ranges, (x, y, float(np.cos(theta)), float(np.sin(theta))), beams,
        geometry.frame, plan.reading_filter, plan.log_odds_update, grid.log_odds_prior, box, written,
    )  # fmt: skip
    return None if count == BEYOND else (count, box, written[:n] if n <= MOST_WRITTEN else None)


@lru_cache(maxsize=32)
def _even_directions(sign: float, angle_min: float, angle_increment: float, n_beams: int) -> NDArray[np.float64]:
    """Return the cosine and sine (n_beams, 2) of the bearings. It is shared and must not be modified."""
    angles = angle_min + angle_increment * np.arange(n_beams)
    return directions((-angles if sign < 0.0 else angles).tobytes())
