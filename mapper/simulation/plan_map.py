"""Floor plan of a world as a map for localization, optionally with moved furniture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.simulation.shapes import Polygon
from mapper.simulation.worlds import World

SURE = 4.0  #: log-odds of a cell of the plan, of either sign
LONGEST = 2.7  #: metres: a longer solid is a wall or a core,
THINNEST = 0.2  #: as is one that is no wider than this
POST = 0.5  #: metres: unless it is also no longer than this, such as the leg of a table
_WAYS = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])


def plan_map(world: World, resolution: float = 0.05) -> OccupancyGrid:
    """Return a map of a world in the plane of the lidar.

    Cells that touch the face of a solid are occupied, those inside solids unknown; all others within the world's bounds
    are free. ``resolution`` is in metres per cell.
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


def is_furniture(solid: Polygon) -> bool:
    """Return whether a polygon (n, 2) is small enough to be furniture, and not a piece of a wall."""
    short, long = np.sort(np.ptp(solid, axis=0)).tolist()
    return bool(long <= LONGEST and (short > THINNEST or long <= POST))


def with_moved_furniture(world: World) -> World:
    """Return a world whose furniture is shifted by one metre relative to ``world``.

    Each piece is moved east, north, west or south, in the first direction in which its centre is free; a piece that is
    blocked on all sides is not moved.
    """
    bare = replace(world, solids=tuple(solid for solid in world.solids if not is_furniture(solid)))

    def moved(solid: Polygon) -> Polygon:
        if not is_furniture(solid):
            return solid
        room = 0.5 * float(np.ptp(solid, axis=0).max())
        free = bare.clearance(solid.mean(axis=0) + _WAYS) >= room
        return solid + _WAYS[int(np.argmax(free))] if free.any() else solid

    return replace(world, solids=tuple(moved(solid) for solid in world.solids))
