"""The update of Moravec and Elfes: scans one after another on one thread."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OccupancyGrid
from mapper.mapping.kernels.moravec_elfes import add_certainties
from mapper.mapping.kernels.types import Scans
from mapper.mapping.update_plan import UpdatePlan


def update_certainties(
    grid: OccupancyGrid, scans: Scans, plan: UpdatePlan, box: NDArray[np.int64], watched: int = -1
) -> tuple[int, NDArray[np.int64], NDArray[np.float32]]:
    """Add all scans to the certainties in ``grid.cell_statistics``; widen ``box`` (4,) to hold what was touched.

    Return the number of cell updates and, of the cell number ``watched`` (row · cols + col, −1: none), the readings
    (n, 2) that touched it, as :func:`mapper.mapping.provenance.contributions`, and its certainties after each
    (n, 2): occupied, empty.
    """
    assert grid.cell_statistics is not None  # noqa: S101 - begun before
    occupied, empty = (statistic.reshape(-1) for statistic in grid.cell_statistics)
    room = 2 * scans.ranges.size if watched >= 0 else 0
    touches, certainties = np.empty((room, 2), np.int64), np.empty((room, 2), np.float32)
    count, n = add_certainties(
        occupied, empty, grid.observed.reshape(-1), grid.geometry.cols, scans,
        grid.geometry.frame, plan.reading_filter, plan.cone.opening, box, watched, touches, certainties,
    )  # fmt: skip
    return count, touches[:n], certainties[:n]
