"""The update of models whose evidence varies within a beam's field: sonar cones, and the smooth ramp per scan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OccupancyGrid
from mapper.mapping.bands import draw_in_bands
from mapper.mapping.kernels.cones import draw_cones
from mapper.mapping.kernels.types import Cells, LogOddsUpdate
from mapper.mapping.turns import Turns


def draw_cone_evidence(
    grid: OccupancyGrid,
    turns: Turns,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``; return the number of cell updates and widen ``box`` (4,) to hold what was touched."""
    cells = Cells(grid.log_odds.reshape(-1), grid.observed.reshape(-1), grid.geometry.cols)
    marks_endpoints = any(plan.cone.mark_endpoints for _, plan in turns.sensors)
    marked = np.zeros(grid.log_odds.size if marks_endpoints else 0, dtype=np.bool_)
    pieces = turns.pieces

    def draw(row_low: int, row_high: int, box: NDArray[np.int64]) -> int:
        count = 0
        for scans, plan in pieces:
            count += draw_cones(
                cells, scans, grid.geometry.frame, plan.reading_filter, plan.cone, plan.evidence, marked,
                log_odds_update, row_low, row_high, box,
            )  # fmt: skip
        return count

    evenly = np.ones(grid.geometry.rows)
    return draw_in_bands(draw, evenly, (0, len(evenly)), threads, box)
