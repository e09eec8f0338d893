"""Occupancy grids: geometry, log-odds of each cell, and computations on whole grids."""

from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import (
    FREE,
    FREE_THRESHOLD,
    OCCUPIED,
    OCCUPIED_THRESHOLD,
    TILE,
    UNKNOWN,
    GridGeometry,
    OccupancyGrid,
    log_odds,
    probability,
)

__all__ = [
    "FREE",
    "FREE_THRESHOLD",
    "OCCUPIED",
    "OCCUPIED_THRESHOLD",
    "TILE",
    "UNKNOWN",
    "CellBox",
    "GridGeometry",
    "OccupancyGrid",
    "log_odds",
    "probability",
]
