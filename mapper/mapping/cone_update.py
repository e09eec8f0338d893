"""The update of models whose evidence varies within a beam's field: sonar cones, and the smooth ramp per scan."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OccupancyGrid
from mapper.mapping.bands import draw_in_bands
from mapper.mapping.kernels.cones import draw_cones
from mapper.mapping.kernels.types import Cells, LogOddsUpdate
from mapper.mapping.scan_batch import ScanBatch
from mapper.mapping.update_plan import UpdatePlan


def draw_cone_evidence(
    grid: OccupancyGrid,
    batch: ScanBatch,
    plan: UpdatePlan,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``; return the number of cell updates and widen ``box`` (4,) to hold what was touched."""
    draw = partial(
        draw_cones,
        Cells(grid.log_odds.reshape(-1), grid.observed.reshape(-1), grid.geometry.cols),
        batch.scans_on(grid.geometry),
        grid.geometry.frame,
        plan.reading_filter,
        plan.cone,
        plan.evidence,
        np.zeros(grid.log_odds.size if plan.cone.mark_endpoints else 0, dtype=np.bool_),
        log_odds_update,
    )
    evenly = np.ones(grid.geometry.rows)
    return draw_in_bands(draw, evenly, (0, len(evenly)), threads, box)
