"""The plan of a world from before its furniture was moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.simulation.shapes import Polygon
from mapper.simulation.worlds import World

LONGEST = 2.7  #: metres: a longer solid is a wall or a core,
THINNEST = 0.2  #: and so is one that is no wider than this
POST = 0.5  #: metres: unless it is no longer than this either, as the leg of a table
_WAYS = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])


def is_furniture(solid: Polygon) -> bool:
    """Return whether a polygon (n, 2) is small enough to be furniture, and no piece of a wall."""
    short, long = np.sort(np.ptp(solid, axis=0)).tolist()
    return bool(long <= LONGEST and (short > THINNEST or long <= POST))


def with_moved_furniture(world: World, distance: float = 1.0) -> World:
    """Return a world whose furniture stands ``distance`` metres from where it does in ``world``.

    Each piece is moved east, north, west or south, in the first direction in which its middle is free; a piece that is
    hemmed in stays.
    """
    bare = replace(world, solids=tuple(solid for solid in world.solids if not is_furniture(solid)))

    def moved(solid: Polygon) -> Polygon:
        if not is_furniture(solid):
            return solid
        ways = distance * _WAYS
        room = 0.5 * float(np.ptp(solid, axis=0).max())
        free = bare.clearance(solid.mean(axis=0) + ways) >= room
        return solid + ways[int(np.argmax(free))] if free.any() else solid

    return replace(world, solids=tuple(moved(solid) for solid in world.solids))
