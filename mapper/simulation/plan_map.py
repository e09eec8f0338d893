"""The plan of a world as a map, such as a robot is given that is to find itself in it."""

from __future__ import annotations

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.simulation.worlds import World

SURE = 4.0  #: log-odds of a cell of the plan, either way


def plan_map(world: World, resolution: float = 0.05) -> OccupancyGrid:
    """Return a map of a world in the plane of the lidar.

    Cells that touch the face of a solid are occupied, those inside solids unknown; all others within the
    world's bounds are free. ``resolution`` is metres a cell.
    """
    x0, y0, x1, y1 = world.bounds
    grid = OccupancyGrid(GridGeometry.covering((x0, y0), (x1, y1), resolution))
    cells = np.stack(np.meshgrid(*map(np.arange, grid.geometry.shape), indexing="ij"), axis=-1)
    clearance = world.in_laser_plane().clearance(grid.geometry.cell_to_world(cells))
    wall = np.isfinite(clearance) & (np.abs(clearance) <= 0.5 * resolution * np.sqrt(2.0))
    free = np.isfinite(clearance) & (clearance > 0.0) & ~wall
    grid.observed = wall | free
    grid.log_odds = np.where(wall, SURE, np.where(free, -SURE, 0.0)).astype(np.float32)
    return grid
