"""Relaxation of the corners of a path in plain NumPy: the kernel must do the same, to the last bit."""

from __future__ import annotations

import numpy as np

from mapper.simulation.worlds import Float64Array, World


def relaxed(world: World, path: Float64Array, least: float, rounds: int) -> Float64Array:
    """Return ``path`` (n, 2), metres, with its corners relaxed, its ends as they are.

    ``rounds`` times each point moves half of the way to the middle of its neighbours, unless its clearance there is
    less than ``least`` metres and less than it was at first: Laplacian smoothing with a constraint.
    """
    path = path.copy()
    floor = np.minimum(world.clearance(path), least)
    for _ in range(rounds):
        moved = path.copy()
        moved[1:-1] = 0.5 * path[1:-1] + 0.25 * (path[:-2] + path[2:])
        kept = world.clearance(moved) >= floor
        path[kept] = moved[kept]
    return path
